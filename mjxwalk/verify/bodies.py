"""Bodies in C MuJoCo, float64, stepped with forces that are worked out anew from its Jacobians.

Independent of `mjxwalk.envs`: kinematics, Jacobians, bias forces and mass matrix are C MuJoCo's,
the laws of ground and joint stops those of `laws`, and accelerations come from a dense solve, or
for explicit steps of the planar body from C MuJoCo's own. Shared: the bodies' XML and settings.
"""

from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Int

from mjxwalk.envs import (
    Action,
    Flame,
    Planar7,
    RandomWalk,
    SerpentineWalk,
    flame_body,
    planar7,
    planar7_body,
)
from mjxwalk.envs._mujoco import compiled, mujoco
from mjxwalk.verify import laws
from mjxwalk.verify.laws import Push

BODIES = (Planar7, Flame)


class Body(NamedTuple):
    """What of a body is its own.

    Attributes:
      spec: the `mujoco.MjSpec`.
      model: the `mujoco.MjModel` of it.
      tie: rates of the joints as a matrix times those of the body's coordinates.
      coordinates: joints whose values are the coordinates.
      motors: their joints, in the order of an action.
      limits: least and greatest torque of each, N m; infinite where it has none.
      stopped: joints with stops.
      sites: of contact.
      feet: ids of their bodies, left and right.
      tangents: 1 in the plane, 2 in space.
    """

    spec: Any
    model: Any
    tie: Float[np.ndarray, "joint coordinate"]
    coordinates: list[int]
    motors: list[int]
    limits: Float[np.ndarray, "motor 2"]
    stopped: list[int]
    sites: list[int]
    feet: list[int]
    tangents: int

    def herd(self, num: int) -> Any:
        """Returns the `mujoco.MjModel` of so many bodies, which do not feel each other."""
        whole, option = mujoco.MjSpec(), self.spec.option
        # Else MuJoCo warns that the bodies' options, other than the whole's, are lost.
        whole.option.timestep, whole.option.jacobian = option.timestep, option.jacobian
        whole.option.disableflags = option.disableflags
        for number in range(num):
            whole.attach(self.spec.copy(), prefix=f"{number}/", frame=whole.worldbody.add_frame())
        return compiled(whole)


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
    """Walkers of one body, each on a ground of its own, as so many trees of one model.

    C MuJoCo moves them all in a call; what Python does, it does with arrays of all of them.

    Attributes:
      data: the `mujoco.MjData` of all.
      qpos: of the joints [walker, joint], m and rad; the data's own.
      qvel: their rates, likewise.
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
        self.env, num = env, len(qpos)
        self.body = planar(env) if isinstance(env, Planar7) else spatial(env)
        self.heights = np.asarray(heights, np.float64)
        self.data = mujoco.MjData(self.body.herd(num))
        self.qpos = self.data.qpos.reshape(num, -1)
        self.qvel = self.data.qvel.reshape(num, -1)
        self.qpos[:] = np.asarray(qpos) @ self.body.tie.T
        self.qvel[:] = np.asarray(qvel) @ self.body.tie.T
        self.stretch = np.zeros((num, len(self.body.sites), self.body.tangents))
        self._places = Places.of(self.body, num)

    @property
    def implicit(self) -> bool:
        """Whether forces are taken at the end of the step."""
        return self.env.integrator == "implicit"

    def step(self, action: Action, walking: Bool[np.ndarray, " walker"] | None = None) -> Step:
        """Moves walkers on by one step.

        Args:
          action: numpy arrays [walker, motor].
          walking: who moves; None for all.
        """
        dt, motors = self.env.timestep, self.body.motors
        mujoco.mj_fwdPosition(self.data.model, self.data)
        mujoco.mj_fwdVelocity(self.data.model, self.data)
        before = self.qpos.copy(), self.qvel.copy()
        feet = self.data.xpos[self._places.feet]
        force, inertia, push = self._ground()
        diagonal = self._on_joints(force)
        angle, rate = before[0][:, motors], before[1][:, motors]
        asked = _motor(action, angle, rate, dt * self.implicit)
        limited = np.clip(asked, *self.body.limits.T)
        force[:, motors] += limited
        if self.implicit:
            added = dt * (np.asarray(action.damping) + dt * np.asarray(action.stiffness))
            # A motor at its limit does not yield to what the step brings.
            diagonal[:, motors] += np.where(limited == asked, added, 0.0)
        joints = np.arange(self.body.model.nv)
        inertia[:, joints, joints] += diagonal
        self._move(force, inertia)
        held = self.qvel[:, motors] if self.implicit else rate
        gave = _motor(action, angle, held, dt * self.implicit)
        done = Step(push, feet, np.where(limited == asked, gave, limited), held.copy())
        if walking is None or walking.all():
            self.stretch = push.stretch
        else:
            self.place(~walking, *before)
            self.stretch = np.where(walking[:, None, None], push.stretch, self.stretch)
        return done._replace(rate=self.qvel[:, motors].copy())

    def place(self, which: Bool[np.ndarray, " walker"], qpos: Any, qvel: Any) -> None:
        """Puts some of the walkers where all of these are [walker, joint]."""
        self.qpos[which], self.qvel[which] = qpos[which], qvel[which]

    def coordinates(self) -> tuple[Any, Any]:
        """Returns the body's coordinates and their rates [walker, coordinate]."""
        return self.qpos[:, self.body.coordinates], self.qvel[:, self.body.coordinates]

    def _ground(self) -> tuple[Any, Any, Push]:
        """Returns the ground's generalised force J^T f and inertia J^T m J, and its push."""
        num = len(self.qpos)
        points = self.data.site_xpos[self._places.sites]
        jacobian = self.jacobian(points).reshape(num, -1, self.qvel.shape[1])
        shape: RandomWalk | SerpentineWalk = self.env.terrain
        ground = laws.height(shape, self.heights, points[..., 0], points[..., 1])
        push = laws.ground_push(
            self.env.contact,
            ground - points[..., 2],
            (jacobian @ self.qvel[:, :, None]).reshape(points.shape),
            self.stretch,
            timestep=self.env.timestep,
            implicit=self.implicit,
        )
        load = push.force
        if self.implicit and self.body.tangents == 2:
            arms = points - self.qpos[:, None, :3]
            turning = np.broadcast_to(self._turning()[:, None], arms.shape)
            load = load - push.mass[..., None] * _cross(turning, arms)
        transposed = np.swapaxes(jacobian, 1, 2)
        weighted = np.repeat(push.mass, 3, axis=1)[..., None] * jacobian
        force = transposed @ load.reshape(num, -1, 1)
        return force[..., 0], transposed @ weighted, push

    def jacobian(self, points: Float[np.ndarray, "walker site 3"]) -> Any:
        """Returns what every joint does to the sites [walker, site, 3, joint].

        From C MuJoCo's axes of motion, which it gives about each tree's centre of mass.
        """
        num, sites = points.shape[:2]
        arms = points - self.data.subtree_com[self._places.roots]
        x, y, z = arms[..., 0], arms[..., 1], arms[..., 2]
        shift = np.zeros((num, sites, 3, 6))
        shift[..., 0, 1], shift[..., 0, 2] = z, -y
        shift[..., 1, 2], shift[..., 1, 0] = x, -z
        shift[..., 2, 0], shift[..., 2, 1] = y, -x
        shift[..., [0, 1, 2], [3, 4, 5]] = 1.0
        axes = np.swapaxes(self.data.cdof.reshape(num, -1, 6), 1, 2)
        return (shift.reshape(num, -1, 6) @ axes).reshape(num, sites, 3, -1) * self._places.moves

    def _on_joints(self, force: Any) -> Any:
        """Adds stops and passive springs to the force; returns what they add to the diagonal."""
        model, dt, stopped = self.body.model, self.env.timestep, self.body.stopped
        diagonal = np.zeros_like(force)
        torque, inertia = laws.stop_torque(
            self.env.joint_stop,
            self.qpos[:, stopped],
            self.qvel[:, stopped],
            model.jnt_range[stopped],
            timestep=dt,
            implicit=self.implicit,
        )
        force[:, stopped] += torque
        diagonal[:, stopped] += inertia
        if not self.implicit and self.body.tangents == 1:
            return diagonal  # C MuJoCo's own step adds passive forces
        force += self.data.qfrc_passive.reshape(force.shape)
        if self.implicit:
            force -= dt * model.jnt_stiffness * self.qvel
            diagonal += dt * (model.dof_damping + dt * model.jnt_stiffness)
        return diagonal

    def _move(self, force: Any, inertia: Any) -> None:
        """Moves positions and rates on, by a mass matrix projected on the tie."""
        tie, dt = self.body.tie, self.env.timestep
        if not self.implicit and self.body.tangents == 1:
            self.data.qfrc_applied[:] = force.ravel()
            mujoco.mj_step2(self.data.model, self.data)
            return
        rows, columns = self._places.rows, self._places.columns
        mass, found = inertia, self.data.M.reshape(len(force), -1)
        mass[:, rows, columns] += found
        off = rows != columns
        mass[:, columns[off], rows[off]] += found[:, off]
        force = force - self.data.qfrc_bias.reshape(force.shape)
        solved = np.linalg.solve(tie.T @ mass @ tie, (force @ tie)[..., None])[..., 0]
        self.qvel += dt * solved @ tie.T
        self.qpos += dt * self.qvel

    def _turning(self) -> Any:
        """Returns the torso's angular acceleration at constant Euler rates.

        The implicit part of contact resists accelerations of the points, up to terms of their
        rates squared, which depend on the coordinates: the environment takes the torso's angular
        acceleration for one, where the Jacobians here have the Euler angles.
        """
        changes = self.data.cdof_dot.reshape(len(self.qpos), -1, 6)[:, :6, :3]
        return (self.qvel[:, None, :6] @ changes)[:, 0]


class Places(NamedTuple):
    """Where one walker's numbers lie.

    Attributes:
      feet: of every walker, among the bodies of all [walker, 2].
      roots: likewise, of the torso [walker, 1].
      sites: of contact, likewise.
      moves: 1 where a joint moves a site, else 0.
      rows: of the numbers that C MuJoCo keeps of a symmetric mass matrix.
      columns: likewise.
    """

    feet: Int[np.ndarray, "walker 2"]
    roots: Int[np.ndarray, "walker 1"]
    sites: Int[np.ndarray, "walker site"]
    moves: Float[np.ndarray, "site 1 joint"]
    rows: Int[np.ndarray, " number"]
    columns: Int[np.ndarray, " number"]

    @classmethod
    def of(cls, body: Body, num: int) -> "Places":
        """Returns those of so many walkers."""
        model = body.model
        moves = np.zeros((len(body.sites), 1, model.nv))
        for row, site in enumerate(body.sites):
            link = int(model.site_bodyid[site])
            while link:
                first = int(model.body_dofadr[link])
                moves[row, 0, first : first + int(model.body_dofnum[link])] = 1.0
                link = int(model.body_parentid[link])
        rows = np.repeat(np.arange(model.nv), model.M_rownnz)
        walkers = np.arange(num)[:, None]
        bodies = (model.nbody - 1) * walkers  # they share the world
        feet, sites = bodies + body.feet, model.nsite * walkers + body.sites
        return cls(feet, bodies + 1, sites, moves, rows, np.array(model.M_colind))


def planar(env: Planar7) -> Body:
    """Returns the seven-link body."""
    spec = planar7_body.with_masses(env.body, env.masses)
    model = _without_solver(spec, env.timestep)
    motors = list(range(3, 9))
    return Body(
        spec=spec,
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
    model = _without_solver(spec, env.timestep)
    motors = [6, 7, 8, 9, 12, 13, 14]
    return Body(
        spec=spec,
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


def _without_solver(spec: Any, timestep: float) -> Any:
    """Returns the `mujoco.MjModel` without contacts, constraints and MuJoCo's implicit damping."""
    disable = mujoco.mjtDisableBit
    spec.option.disableflags |= disable.mjDSBL_CONTACT | disable.mjDSBL_CONSTRAINT
    spec.option.disableflags |= disable.mjDSBL_EULERDAMP
    spec.option.timestep = timestep
    return compiled(spec)


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


def _cross(one: Any, other: Any) -> Any:
    """Returns cross products, some times as fast as NumPy's for few vectors."""
    (a, b, c), (x, y, z) = np.moveaxis(one, -1, 0), np.moveaxis(other, -1, 0)
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)


def _motor(action: Action, angle: Any, rate: Any, ahead: float) -> Any:
    """Returns the motors' torque, N m, with angles moved on by so many seconds."""
    off_target = np.asarray(action.target) - angle - ahead * rate
    spring = np.asarray(action.stiffness) * off_target
    return np.asarray(action.torque) + spring - np.asarray(action.damping) * rate
