"""The hip-powered biped in C MuJoCo, float64, its forces worked out anew from the Jacobians."""

import itertools
from typing import Any

import mujoco as _mujoco
import numpy as np

from mjxwalk.envs import Reil

mujoco: Any = _mujoco
HIPS = [7, 11]
SPHERES = ["heel_left", "toe_left", "heel_right", "toe_right"]


class Reference:
    """One walker on level ground at height zero, stepped by C MuJoCo."""

    def __init__(self, env: Reil, qpos: Any, qvel: Any, load: float = 0.0) -> None:
        self.env = env
        self.model = env.model.mujoco if not load else loaded(env, load)
        self.data = mujoco.MjData(self.model)
        self.data.qpos[:], self.data.qvel[:] = qpos, qvel
        self.stretch = np.zeros((4, 2))
        self.torque_cost = 0.0
        self.hit_limit = False  # of a motor, in any step
        self.touched = False  # the ground, likewise

    @property
    def implicit(self) -> bool:
        return self.env.integrator == "implicit"

    def step(self, target: Any) -> None:
        """Moves on by one step, with a dense mass matrix."""
        data, dt, env = self.data, self.env.timestep, self.env
        mujoco.mj_forward(self.model, data)
        force, inertia = self._contact()
        for more, resisting in (self._springs(), self._knee_caps(), self._assistance()):
            force += more
            inertia += resisting
        mass = np.zeros((14, 14))
        mujoco.mj_fullM(self.model, data, mass)
        mass += inertia
        coasting = np.linalg.solve(mass, force - data.qfrc_bias)
        answer = np.linalg.solve(mass, np.eye(14)[:, HIPS])
        law = env.hips
        request = law.approach * (target - data.qpos[HIPS])
        request = np.clip(request, -law.max_speed, law.max_speed)
        wanted = request - data.qvel[HIPS] - dt * coasting[HIPS]
        soft = dt * answer[HIPS] + law.softness * np.eye(2)
        torque = best_in_box(soft, wanted, law.max_torque)
        self.hit_limit |= bool(np.any(np.abs(torque) == law.max_torque))
        self.torque_cost += dt * np.abs(torque).sum()
        data.qvel[:] += dt * (coasting + answer @ torque)
        data.qpos[:] += dt * data.qvel

    def _contact(self) -> tuple[Any, Any]:
        """Generalised force and inertia of the ground, by J^T f and J^T m J."""
        law, dt = self.env.contact, self.env.timestep
        damping = law.damping + (law.stiffness * dt if self.implicit else 0.0)
        force, inertia = np.zeros(14), np.zeros((14, 14))
        for index, name in enumerate(SPHERES):
            sphere = self.model.geom(name)
            point = self.data.geom_xpos[sphere.id] - [0.0, 0.0, sphere.size[0]]
            jacobian = np.zeros((3, 14))
            body = int(sphere.bodyid[0])
            mujoco.mj_jac(self.model, self.data, jacobian, None, point, body)
            velocity = jacobian @ self.data.qvel
            if point[2] >= 0:
                self.stretch[index] = 0.0
                continue
            self.touched = True
            self.stretch[index] += dt * velocity[:2]
            normal = max(0.0, -law.stiffness * point[2] - damping * velocity[2])
            limit = law.friction * normal
            along = shortened(-law.stiffness * self.stretch[index] - damping * velocity[:2], limit)
            self.stretch[index] = shortened(self.stretch[index], limit / law.stiffness)
            force += jacobian.T @ np.append(along, normal)
            if self.implicit and normal > 0:
                mass = dt * damping
                inertia += mass * jacobian.T @ jacobian
                turning = np.cross(self._turning()[1], point - self.data.qpos[:3])
                force -= mass * jacobian.T @ turning
        return force, inertia

    def _turning(self) -> tuple[Any, Any]:
        """The trunk's rotational Jacobian, and its angular acceleration at constant Euler rates.

        What is implicit resists accelerations, up to terms of rates squared, which depend on the
        coordinates: the environment takes the trunk's angular acceleration for one.
        """
        jacobian, change = np.zeros((3, 14)), np.zeros((3, 14))
        torso = self.model.body("torso").id
        origin = self.data.xpos[torso]
        mujoco.mj_jac(self.model, self.data, None, jacobian, origin, torso)
        mujoco.mj_jacDot(self.model, self.data, None, change, origin, torso)
        return jacobian, change @ self.data.qvel

    def _springs(self) -> tuple[Any, Any]:
        env, dt = self.env, self.env.timestep
        rest, stiffness, damping = np.zeros(14), np.zeros(14), np.zeros(14)
        stiffness[[6, 10]], damping[[6, 10]] = env.hip_roll_stiffness, env.hip_roll_damping
        damping[[8, 12]] = env.knee_damping
        stiffness[[9, 13]], damping[[9, 13]] = env.ankle_stiffness, env.ankle_damping
        rest[[9, 13]] = env.ankle_rest
        force = stiffness * (rest - self.data.qpos) - damping * self.data.qvel
        if not self.implicit:
            return force, np.zeros((14, 14))
        force -= dt * stiffness * self.data.qvel
        return force, np.diag(dt * (damping + dt * stiffness))

    def _knee_caps(self) -> tuple[Any, Any]:
        env, dt = self.env, self.env.timestep
        law = env.knee_cap
        damping = law.damping + (law.stiffness * dt if self.implicit else 0.0)
        torque, inertia = np.zeros(14), np.zeros(14)
        for knee in (8, 12):
            angle, rate = self.data.qpos[knee], self.data.qvel[knee]
            if env.knee_extension <= angle <= env.knee_flexion:
                continue
            nearest = env.knee_extension if angle < env.knee_extension else env.knee_flexion
            push = law.stiffness * (nearest - angle) - damping * rate
            if push * (nearest - angle) > 0:
                torque[knee] = push
                inertia[knee] = dt * damping if self.implicit else 0.0
        return torque, np.diag(inertia)

    def _assistance(self) -> tuple[Any, Any]:
        env, dt = self.env, self.env.timestep
        torso = self.data.body("torso")
        upward = torso.xmat.reshape(3, 3)  # the trunk's axes as columns
        jacobian, turning = self._turning()
        spin = upward.T @ jacobian @ self.data.qvel
        damping = env.assistance_damping + (dt * env.assistance if self.implicit else 0.0)
        # The cross product of the trunk's vertical and the world's, about the trunk's x and y.
        off = upward.T @ np.cross(upward[:, 2], [0.0, 0.0, 1.0]) * env.assistance
        off[1] += env.assistance * np.sin(env.assistance_lean)
        tilting = np.array([env.assistance_roll, 1.0, 0.0])
        own = upward.T @ jacobian
        force = own.T @ (tilting * (off - damping * spin))
        if not self.implicit:
            return force, np.zeros((14, 14))
        resisting = np.diag(dt * damping * tilting)
        return force - own.T @ resisting @ upward.T @ turning, own.T @ resisting @ own


def loaded(env: Reil, load: float) -> Any:
    """Returns the model with a small, heavy ball fixed to the trunk's centre."""
    from mjxwalk.envs.bodies import reil_body

    spec = reil_body.build_spec(env.offsets)
    ball = spec.body("torso").add_body(pos=[0.0, 0.0, env.trunk_height])
    ball.mass, ball.inertia, ball.ipos, ball.explicitinertial = load, [1e-9] * 3, [0.0] * 3, True
    return spec.compile()


def best_in_box(matrix: Any, wanted: Any, limit: float) -> Any:
    """Returns the minimum of x A x / 2 - x b with |x| up to the limit, by trying every face."""
    candidates: list[Any] = []
    for held in itertools.product([None, -limit, limit], repeat=2):
        free = [i for i in (0, 1) if held[i] is None]
        x = np.array([0.0 if value is None else value for value in held])
        right = wanted - matrix @ x
        if free:
            x[free] = np.linalg.solve(matrix[np.ix_(free, free)], right[free])
        if np.all(np.abs(x) <= limit):
            candidates.append(x)
    return min(candidates, key=lambda x: 0.5 * x @ matrix @ x - x @ wanted)


def shortened(vector: Any, limit: float) -> Any:
    """Returns the vector, no longer than the limit."""
    length = np.hypot(*vector)
    return vector if length <= limit else vector * (limit / length)
