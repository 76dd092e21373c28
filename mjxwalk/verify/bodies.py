"""Bodies in C MuJoCo, float64, stepped with forces that are worked out anew from its Jacobians.

Independent of `mjxwalk.envs`: kinematics, Jacobians, bias forces and mass matrix are C MuJoCo's,
the laws of ground and joint stops those of `laws`, and accelerations come from a dense solve, or
for explicit steps of the planar body from C MuJoCo's own. Shared: the bodies' XML and settings.
"""

import copy
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float, Int

from mjxwalk.envs import Action, Flame, Planar7, RandomWalk, SerpentineWalk, flame_body, planar7
from mjxwalk.envs._mujoco import mujoco
from mjxwalk.verify import laws
from mjxwalk.verify.laws import Push

BODIES = (Planar7, Flame)


class Body(NamedTuple):
    """What of a body is its own.

    Attributes:
      model: the `mujoco.MjModel`.
      tie: rates of the joints as a matrix times those of the body's coordinates.
      coordinates: joints whose values are the coordinates.
      motors: their joints, in the order of an action.
      limits: least and greatest torque of each, N m; infinite where it has none.
      stopped: joints with stops.
      sites: of contact.
      feet: ids of their bodies, left and right.
      tangents: 1 in the plane, 2 in space.
    """

    model: Any
    tie: Float[np.ndarray, "joint coordinate"]
    coordinates: list[int]
    motors: list[int]
    limits: Float[np.ndarray, "motor 2"]
    stopped: list[int]
    sites: list[int]
    feet: list[int]
    tangents: int


class Step(NamedTuple):
    """What a step saw and gave.

    Attributes:
      push: of the ground.
      feet: where the feet's bodies were, m.
      torque: of the motors, N m.
      rate: of their joints after the step, rad/s.
    """

    push: Push
    feet: Float[np.ndarray, "walker 2 3"]
    torque: Float[np.ndarray, "walker motor"]
    rate: Float[np.ndarray, "walker motor"]


class Walkers:
    """Walkers of one body, each on a ground of its own.

    Attributes:
      datas: a `mujoco.MjData` for each, which `place` keeps in step with the next two.
      qpos: of the joints [walker, joint], m and rad.
      qvel: their rates.
      stretch: of the ground's tangential springs, m.
    """

    def __init__(self, env: Planar7 | Flame, qpos: Any, qvel: Any, heights: Any) -> None:
        """Places walkers.

        Args:
          env: body, ground and step.
          qpos: coordinates [walker, coordinate], m and rad.
          qvel: their rates.
          heights: of each walker's ground [walker, *node], m.
        """
        self.env = env
        self.body = planar(env) if isinstance(env, Planar7) else spatial(env)
        self.heights = np.asarray(heights, np.float64)
        self.datas = [mujoco.MjData(self.body.model) for _ in qpos]
        self.qpos, self.qvel = (
            np.asarray(qpos) @ self.body.tie.T,
            np.asarray(qvel) @ self.body.tie.T,
        )
        self.place(np.arange(len(self.datas)), self.qpos, self.qvel)
        self.stretch = np.zeros((len(self.datas), len(self.body.sites), self.body.tangents))

    @property
    def implicit(self) -> bool:
        """Whether forces are taken at the end of the step."""
        return self.env.integrator == "implicit"

    def step(self, action: Action, walking: Int[np.ndarray, " walking"] | None = None) -> Step:
        """Moves walkers on by one step.

        Args:
          action: numpy arrays [walker, motor], of those that walk.
          walking: their numbers; None for all.
        """
        walking = np.arange(len(self.datas)) if walking is None else walking
        datas, model, dt = [self.datas[i] for i in walking], self.body.model, self.env.timestep
        for data in datas:
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_fwdVelocity(model, data)
        qpos, qvel = self.qpos[walking], self.qvel[walking]
        feet = np.array([data.xpos[self.body.feet] for data in datas])
        force, inertia, push = self._ground(datas, qpos, qvel, walking)
        diagonal = self._on_joints(force, qpos, qvel, datas)
        angle, rate = qpos[:, self.body.motors], qvel[:, self.body.motors]
        asked = _motor(action, angle, rate, dt * self.implicit)
        limited = np.clip(asked, *self.body.limits.T)
        force[:, self.body.motors] += limited
        if self.implicit:
            added = dt * (np.asarray(action.damping) + dt * np.asarray(action.stiffness))
            # A motor at its limit does not yield to what the step brings.
            diagonal[:, self.body.motors] += np.where(limited == asked, added, 0.0)
        joints = np.arange(model.nv)
        inertia[:, joints, joints] += diagonal
        self.place(walking, *self._moved(datas, qpos, qvel, force, inertia))
        self.stretch[walking] = push.stretch
        after = self.qvel[walking][:, self.body.motors]
        held = after if self.implicit else rate
        gave = _motor(action, angle, held, dt * self.implicit)
        return Step(push, feet, np.where(limited == asked, gave, limited), after)

    def place(self, walking: Int[np.ndarray, " walking"], qpos: Any, qvel: Any) -> None:
        """Puts walkers where they are to be [walking, joint]."""
        self.qpos[walking], self.qvel[walking] = qpos, qvel
        for walker, position, velocity in zip(walking, qpos, qvel, strict=True):
            data = self.datas[walker]
            data.qpos[:], data.qvel[:] = position, velocity

    def coordinates(self) -> tuple[Any, Any]:
        """Returns the body's coordinates and their rates [walker, coordinate]."""
        return self.qpos[:, self.body.coordinates], self.qvel[:, self.body.coordinates]

    def _ground(
        self, datas: list[Any], qpos: Any, qvel: Any, walking: Any
    ) -> tuple[Any, Any, Push]:
        """Returns the ground's generalised force J^T f and inertia J^T m J, and its push."""
        model, sites = self.body.model, self.body.sites
        jacobian = np.zeros((len(datas), len(sites), 3, model.nv))
        for row, data in enumerate(datas):
            for place, site in enumerate(sites):
                mujoco.mj_jacSite(model, data, jacobian[row, place], None, site)
        points = np.array([data.site_xpos[sites] for data in datas])
        shape: RandomWalk | SerpentineWalk = self.env.terrain
        ground = laws.height(shape, self.heights[walking], points[..., 0], points[..., 1])
        push = laws.ground_push(
            self.env.contact,
            ground - points[..., 2],
            np.einsum("wsij,wj->wsi", jacobian, qvel),
            self.stretch[walking],
            timestep=self.env.timestep,
            implicit=self.implicit,
        )
        load = push.force
        if self.implicit and self.body.tangents == 2:
            turning = np.array([self._turning(data) for data in datas])
            arms = points - qpos[:, None, :3]
            load = load - push.mass[..., None] * np.cross(turning[:, None], arms)
        weighted = push.mass[..., None, None] * jacobian
        flat = jacobian.reshape(len(datas), -1, model.nv)
        inertia = np.swapaxes(flat, 1, 2) @ weighted.reshape(flat.shape)
        return np.einsum("wsij,wsi->wj", jacobian, load), inertia, push

    def _on_joints(self, force: Any, qpos: Any, qvel: Any, datas: list[Any]) -> Any:
        """Adds stops and passive springs to the force; returns what they add to the diagonal."""
        model, dt, stopped = self.body.model, self.env.timestep, self.body.stopped
        diagonal = np.zeros_like(force)
        torque, inertia = laws.stop_torque(
            self.env.joint_stop,
            qpos[:, stopped],
            qvel[:, stopped],
            model.jnt_range[stopped],
            timestep=dt,
            implicit=self.implicit,
        )
        force[:, stopped] += torque
        diagonal[:, stopped] += inertia
        if not self.implicit and self.body.tangents == 1:
            return diagonal  # C MuJoCo's own step adds passive forces
        force += np.array([data.qfrc_passive for data in datas])
        if self.implicit:
            force -= dt * model.jnt_stiffness * qvel
            diagonal += dt * (model.dof_damping + dt * model.jnt_stiffness)
        return diagonal

    def _moved(
        self, datas: list[Any], qpos: Any, qvel: Any, force: Any, inertia: Any
    ) -> tuple[Any, Any]:
        """Returns positions and rates a step later, by a mass matrix projected on the tie."""
        model, tie, dt = self.body.model, self.body.tie, self.env.timestep
        if not self.implicit and self.body.tangents == 1:
            for data, one in zip(datas, force, strict=True):
                data.qfrc_applied[:] = one
                mujoco.mj_step2(model, data)
            return np.array([data.qpos for data in datas]), np.array([data.qvel for data in datas])
        mass = np.zeros_like(inertia)
        for data, one in zip(datas, mass, strict=True):
            mujoco.mj_fullM(model, data, one)
        bias = np.array([data.qfrc_bias for data in datas])
        solved = np.linalg.solve(tie.T @ (mass + inertia) @ tie, ((force - bias) @ tie)[..., None])
        qvel = qvel + dt * solved[..., 0] @ tie.T
        return qpos + dt * qvel, qvel

    def _turning(self, data: Any) -> Any:
        """Returns the torso's angular acceleration at constant Euler rates.

        The implicit part of contact resists accelerations of the points, up to terms of their
        rates squared, which depend on the coordinates: the environment takes the torso's angular
        acceleration for one, where the Jacobians here have the Euler angles.
        """
        model = self.body.model
        jacobian = np.zeros((3, model.nv))
        torso = model.body("torso").id
        mujoco.mj_jacDot(model, data, None, jacobian, data.xpos[torso], torso)
        return jacobian @ data.qvel


def planar(env: Planar7) -> Body:
    """Returns the seven-link body."""
    model = copy.copy(env.model.mujoco)
    model.opt.timestep = env.timestep
    motors = list(range(3, 9))
    return Body(
        model=model,
        tie=np.eye(9),
        coordinates=list(range(9)),
        motors=motors,
        limits=_limits(model, motors),
        stopped=list(range(3, 9)),
        sites=[model.site(name).id for name in planar7.CONTACT_SITES],
        feet=[model.body(name).id for name in planar7.FEET],
        tangents=1,
    )


def spatial(env: Flame) -> Body:
    """Returns the nine-link body, its ankles' roll a spring of MuJoCo's."""
    spec = flame_body.spec(env.body)
    for name in ("ankle_roll_left", "ankle_roll_right"):
        spec.joint(name).stiffness[0] = env.ankle_roll_stiffness
        spec.joint(name).damping[0] = env.ankle_roll_damping
    disable = mujoco.mjtDisableBit
    spec.option.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT
    model = spec.compile()
    motors = [6, 7, 8, 9, 12, 13, 14]
    return Body(
        model=model,
        tie=np.insert(np.eye(15), 11, np.eye(15)[6], axis=0),  # both adductions are coordinate 6
        coordinates=[*range(11), *range(12, 16)],
        motors=motors,
        limits=_limits(model, motors),
        stopped=[*range(6, 11), *range(12, 16)],  # the adduction's stop acts on the shared angle
        sites=[model.site(name).id for name in flame_body.CONTACT_SITES],
        feet=[model.body(name).id for name in flame_body.FEET],
        tangents=2,
    )


def _limits(model: Any, joints: list[int]) -> Float[np.ndarray, "motor 2"]:
    """Returns what motors give when C MuJoCo is told to give all, or the opposite of it."""
    data = mujoco.MjData(model)
    found = np.full((model.nv, 2), (-np.inf, np.inf))
    for joint in np.flatnonzero(model.jnt_actfrclimited):
        found[joint] = model.jnt_actfrcrange[joint]
    for actuator in range(model.nu):
        joint = int(model.actuator_trnid[actuator][0])
        if not (model.actuator_ctrllimited[actuator] or model.actuator_forcelimited[actuator]):
            continue
        data.ctrl[:] = 0.0
        gave: list[float] = []
        for all_of_it in (-1e9, 1e9):
            data.ctrl[actuator] = all_of_it
            mujoco.mj_forward(model, data)
            gave.append(float(data.qfrc_actuator[joint]))
        found[joint] = sorted(gave)
    return found[joints]


def _motor(action: Action, angle: Any, rate: Any, ahead: float) -> Any:
    """Returns the motors' torque, N m, with angles moved on by so many seconds."""
    off_target = np.asarray(action.target) - angle - ahead * rate
    spring = np.asarray(action.stiffness) * off_target
    return np.asarray(action.torque) + spring - np.asarray(action.damping) * rate
