"""The planar body in C MuJoCo, float64, with its forces worked out anew from the Jacobians."""

from typing import Any

import mujoco as _mujoco
import numpy as np

from mjxwalk.envs import Planar7
from mjxwalk.envs.planar7 import CONTACT_SITES

mujoco: Any = _mujoco


class Reference:
    """One walker on level ground at height zero, stepped by C MuJoCo."""

    def __init__(self, env: Planar7, qpos: Any, qvel: Any) -> None:
        self.env = env
        self.model = env.model.mujoco
        self.model.opt.timestep = env.timestep
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        self.stretch = np.zeros(4)

    def step(self, torque: Any) -> None:
        """Moves on by one step; implicit forces are solved for with a dense mass matrix."""
        mujoco.mj_step1(self.model, self.data)
        force, inertia = self._contact()
        stop, stop_inertia = self._stops()
        force += stop
        force[3:] += torque
        if self.env.integrator == "explicit":
            self.data.qfrc_applied[:] = force
            mujoco.mj_step2(self.model, self.data)
            return
        mass = np.zeros((9, 9))
        mujoco.mj_fullM(self.model, self.data, mass)
        mass += inertia + np.diag(stop_inertia)
        acceleration = np.linalg.solve(mass, force - self.data.qfrc_bias)
        self.data.qvel[:] += self.env.timestep * acceleration
        self.data.qpos[:] += self.env.timestep * self.data.qvel

    def _contact(self) -> tuple[Any, Any]:
        """Generalised force and inertia of the ground, by J^T f and J^T m J."""
        law, dt = self.env.contact, self.env.timestep
        implicit = self.env.integrator == "implicit"
        damping = law.damping + (law.stiffness * dt if implicit else 0.0)
        force, inertia = np.zeros(9), np.zeros((9, 9))
        for index, name in enumerate(CONTACT_SITES):
            site = self.model.site(name).id
            jacobian = np.zeros((3, 9))
            mujoco.mj_jacSite(self.model, self.data, jacobian, None, site)
            velocity = jacobian @ self.data.qvel
            depth = -self.data.site_xpos[site, 2]
            if depth <= 0:
                self.stretch[index] = 0.0
                continue
            self.stretch[index] += dt * velocity[0]
            normal = max(0.0, law.stiffness * depth - damping * velocity[2])
            limit = law.friction * normal
            sticking = -law.stiffness * self.stretch[index] - damping * velocity[0]
            tangential = min(max(sticking, -limit), limit)
            longest = limit / law.stiffness
            self.stretch[index] = min(max(self.stretch[index], -longest), longest)
            force += jacobian.T @ np.array([tangential, 0.0, normal])
            if implicit and normal > 0:
                inertia += dt * damping * jacobian.T @ jacobian
        return force, inertia

    def _stops(self) -> tuple[Any, Any]:
        law, dt = self.env.joint_stop, self.env.timestep
        implicit = self.env.integrator == "implicit"
        damping = law.damping + (law.stiffness * dt if implicit else 0.0)
        torque, inertia = np.zeros(9), np.zeros(9)
        for joint in range(3, 9):
            lower, upper = self.model.jnt_range[joint]
            angle, rate = self.data.qpos[joint], self.data.qvel[joint]
            if lower <= angle <= upper:
                continue
            nearest = lower if angle < lower else upper
            push = law.stiffness * (nearest - angle) - damping * rate
            if push * (nearest - angle) > 0:
                torque[joint] = push
                inertia[joint] = dt * damping if implicit else 0.0
        return torque, inertia
