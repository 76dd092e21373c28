"""The spatial body in C MuJoCo, float64, with its forces worked out anew from the Jacobians."""

from typing import Any

import mujoco as _mujoco
import numpy as np

from mjxwalk.envs import Flame
from mjxwalk.envs.flame_body import CONTACT_SITES, MODEL_PATH

mujoco: Any = _mujoco
LEFT = [*range(6), 6, 7, 8, 9, 10, 12, 13, 14, 15]  # joints whose values are the coordinates
TIE = np.insert(np.eye(15), 11, np.eye(15)[6], axis=0)  # both adductions follow coordinate 6
MOTORS = [6, 7, 8, 9, 12, 13, 14]


class Reference:
    """One walker on level ground at height zero, stepped by C MuJoCo with the hips tied."""

    def __init__(self, env: Flame, qpos: Any, qvel: Any) -> None:
        self.env = env
        spec = mujoco.MjSpec.from_file(str(MODEL_PATH))
        for name in ("ankle_roll_left", "ankle_roll_right"):
            spec.joint(name).stiffness[0] = env.ankle_roll_stiffness
            spec.joint(name).damping[0] = env.ankle_roll_damping
        disable = mujoco.mjtDisableBit
        spec.option.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:], self.data.qvel[:] = TIE @ qpos, TIE @ qvel
        self.stretch = np.zeros((8, 2))
        self.torque_cost = 0.0

    @property
    def implicit(self) -> bool:
        return self.env.integrator == "implicit"

    def step(self, torque: Any, target: Any, stiffness: Any, damping: Any) -> None:
        """Moves on by one step, with the tied accelerations from a projected dense mass matrix."""
        data, dt = self.data, self.env.timestep
        mujoco.mj_forward(self.model, data)
        force, inertia = self._contact()
        stop, stop_inertia = self._stops()
        force += stop + data.qfrc_passive
        angle, rate = data.qpos[MOTORS], data.qvel[MOTORS]
        force[MOTORS] += torque + stiffness * (target - angle) - damping * rate
        diagonal = stop_inertia
        if self.implicit:
            passive = self.model.jnt_stiffness
            diagonal += dt * (self.model.dof_damping + dt * passive)
            force -= dt * passive * data.qvel
            diagonal[MOTORS] += dt * (damping + dt * stiffness)
            force[MOTORS] -= dt * stiffness * rate
        mass = np.zeros((16, 16))
        mujoco.mj_fullM(self.model, data, mass)
        mass = TIE.T @ (mass + inertia + np.diag(diagonal)) @ TIE
        data.qvel[:] += dt * TIE @ np.linalg.solve(mass, TIE.T @ (force - data.qfrc_bias))
        held = rate if not self.implicit else data.qvel[MOTORS]
        ahead = dt * held if self.implicit else 0.0
        given = torque + stiffness * (target - angle - ahead) - damping * held
        self.torque_cost += dt * np.abs(given).sum()
        data.qpos[:] += dt * data.qvel

    def _contact(self) -> tuple[Any, Any]:
        """Generalised force and inertia of the ground, by J^T f and J^T m J."""
        law, dt = self.env.contact, self.env.timestep
        damping = law.damping + (law.stiffness * dt if self.implicit else 0.0)
        force, inertia = np.zeros(16), np.zeros((16, 16))
        for index, name in enumerate(CONTACT_SITES):
            site = self.model.site(name).id
            jacobian = np.zeros((3, 16))
            mujoco.mj_jacSite(self.model, self.data, jacobian, None, site)
            velocity = jacobian @ self.data.qvel
            point = self.data.site_xpos[site]
            if point[2] >= 0:
                self.stretch[index] = 0.0
                continue
            self.stretch[index] += dt * velocity[:2]
            normal = max(0.0, -law.stiffness * point[2] - damping * velocity[2])
            limit = law.friction * normal
            along = shortened(-law.stiffness * self.stretch[index] - damping * velocity[:2], limit)
            self.stretch[index] = shortened(self.stretch[index], limit / law.stiffness)
            force += jacobian.T @ np.append(along, normal)
            if self.implicit and normal > 0:
                mass = dt * damping
                inertia += mass * jacobian.T @ jacobian
                force -= mass * jacobian.T @ np.cross(self._turning(), point - self.data.qpos[:3])
        return force, inertia

    def _turning(self) -> Any:
        """The torso's angular acceleration at constant Euler rates.

        The implicit part of contact resists accelerations of the points, up to terms of their
        rates squared, which depend on the coordinates: the environment takes the torso's angular
        acceleration for one, where the Jacobians here have the Euler angles.
        """
        jacobian = np.zeros((3, 16))
        torso = self.model.body("torso").id
        origin = self.data.xpos[torso]
        mujoco.mj_jacDot(self.model, self.data, None, jacobian, origin, torso)
        return jacobian @ self.data.qvel

    def _stops(self) -> tuple[Any, Any]:
        law, dt = self.env.joint_stop, self.env.timestep
        damping = law.damping + (law.stiffness * dt if self.implicit else 0.0)
        torque, inertia = np.zeros(16), np.zeros(16)
        for joint in set(range(6, 16)) - {11}:  # the adduction's stop acts on the shared angle
            lower, upper = self.model.jnt_range[joint]
            angle, rate = self.data.qpos[joint], self.data.qvel[joint]
            if lower <= angle <= upper:
                continue
            nearest = lower if angle < lower else upper
            push = law.stiffness * (nearest - angle) - damping * rate
            if push * (nearest - angle) > 0:
                torque[joint] = push
                inertia[joint] = dt * damping if self.implicit else 0.0
        return torque, inertia


def shortened(vector: Any, limit: float) -> Any:
    """Returns the vector, no longer than the limit."""
    length = np.hypot(*vector)
    return vector if length <= limit else vector * (limit / length)
