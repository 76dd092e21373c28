"""Walkers under MuJoCo's own contact law: plain `mj_step` of C MuJoCo moves each of them.

The ground is MuJoCo's plane where a trial's is level, else its height field, whose triangles push
along their own normals; the engines' law pushes up at each point that touches.
"""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import LeggedEnv, MjcfEnv, Trials
from mjxwalk.envs._mujoco import compiled, mujoco
from mjxwalk.envs.derived import file_tree
from mjxwalk.envs.mujoco_law import model as mujoco_model
from mjxwalk.verify import laws, pushes_and_payloads
from mjxwalk.verify.laws import GroundForce
from mjxwalk.verify.pushes_and_payloads import PAYLOAD
from mjxwalk.verify.reference import Reference
from mjxwalk.verify.stepping import Step

GROUND, TORSO, FREE = "ground of the trial", 1, 7
LEAST_ITERATIONS = 100  # of the solver, so that engines that take fewer are seen to err
SPACING, BEHIND, AHEAD, ASIDE, BASE = 0.05, 3.0, 60.0, 4.0, 1.0  # m; of height fields


class MjStep(Reference):
    """The same as `Reference`, with another step."""

    def __init__(self, env: LeggedEnv, qpos: Any, qvel: Any, trials: Trials) -> None:
        """Places walkers; see `Reference`."""
        super().__init__(env, qpos, qvel, trials)
        assert isinstance(env, MjcfEnv)
        self._tree = file_tree.of_text(env.body)
        self._models = [self._model(env, walker) for walker in range(len(qpos))]
        self._datas = [mujoco.MjData(model) for model in self._models]
        for data, place, rate in zip(self._datas, self.qpos, self.qvel, strict=True):
            self._put(data, place, rate)
        self._floors = [_floors(model) for model in self._models]
        legs = self._tree.legs
        points = [self.anatomy.points_of(leg) for leg in self.anatomy.legs]
        self._feet_of = list(zip([set(leg.foot) for leg in legs], points, strict=True))

    def step(self, action: Any, walking: Bool[np.ndarray, " walker"] | None = None) -> Step:
        """Moves walkers on by one step."""
        herd = self.herd
        herd.qpos[:], herd.qvel[:] = self.qpos[:, self._joints], self.qvel[:, self._joints]
        herd.see()
        num, points = len(self._datas), len(self.anatomy.points)
        touching, torque = np.zeros((num, points), bool), np.zeros((num, len(self._driven)))
        qpos, qvel = self.qpos.copy(), self.qvel.copy()
        force = self._pushes()
        on = np.ones(num, bool) if walking is None else walking
        for walker in np.flatnonzero(on).tolist():
            model, data = self._models[walker], self._datas[walker]
            asked, target, stiffness, damping = (part[walker] for part in np.asarray(action))
            bias = np.stack([asked + stiffness * target, -stiffness, -damping], axis=1)
            model.actuator_gainprm[:], model.actuator_biasprm[:, :3] = 0.0, bias
            data.xfrc_applied[TORSO, :3] = force[walker]
            mujoco.mj_step(model, data)
            torque[walker] = data.actuator_force
            touching[walker] = self._touched(walker)
            qpos[walker], qvel[walker] = self._coordinates(data)
        self.qpos, self.qvel = qpos, qvel
        self._num_steps += 1
        nothing = np.zeros((num, points))
        push = GroundForce(np.zeros((num, points, 3)), nothing, self.stretch, touching)
        feet = herd.data.xpos[self._feet]
        return Step(push, feet, herd.centre().copy(), torque, qvel[:, self._driven])

    def _pushes(self) -> Float[np.ndarray, "walker 3"]:
        if self.pushes is None or not self.env.push:
            return np.zeros((len(self._datas), 3))
        return pushes_and_payloads.force(self.env, self._own, self.pushes, self._num_steps)

    def _model(self, env: MjcfEnv, walker: int) -> Any:
        """Returns the `mujoco.MjModel` of a walker, on its own ground, with its payload."""
        spec = mujoco_model.spec_of(env.body, env.solver, env.timestep)
        spec.option.iterations = max(spec.option.iterations, LEAST_ITERATIONS)
        self._lay_ground(spec, walker)
        load = 0.0
        if env.payload and self.load is not None:
            load = self._own.mass * (env.payload.share + self.load[walker] * env.payload.spread)
            torso = list(spec.bodies)[TORSO]
            body = torso.add_body(name=PAYLOAD, pos=self._place(env, spec))
            body.explicitinertial, body.ipos = True, np.zeros(3)
            body.mass, body.inertia = 1e-12, np.full(3, 1e-12)
        model = compiled(spec)
        if load:
            # Set afterwards, so that contacts are as soft as without it.
            number = model.body(PAYLOAD).id
            model.body_mass[number] = load
            model.body_subtreemass[[0, TORSO, number]] += load
        return model

    def _place(self, env: MjcfEnv, spec: Any) -> Float[np.ndarray, "3"]:
        """Returns where the payload is, from the torso's origin in the file's axes, m."""
        return compiled(spec.copy()).body_ipos[TORSO] + self._tree.turn.T @ env.payload.offset

    def _lay_ground(self, spec: Any, walker: int) -> None:
        """Makes height fields of the floors unless the walker's ground is level at height 0."""
        planar = self.anatomy.root.is_planar
        x = np.arange(-BEHIND, AHEAD + 0.5 * SPACING, SPACING)
        y = np.array([-ASIDE, ASIDE]) if planar else np.arange(-ASIDE, ASIDE + SPACING, SPACING)
        across, along = np.meshgrid(np.zeros_like(y) if planar else y, x, indexing="ij")
        course = None if self.course is None else self.course[[walker]]
        heights = laws.height(self.env.terrain, self.heights[[walker]], along[None], across[None])
        heights = (heights + laws.lying(self.env.course, course, along[None]).height)[0]
        if not heights.any():
            return
        low, span = heights.min(), max(float(np.ptp(heights)), 1e-6)
        size = [0.5 * (x[-1] - x[0]), 0.5 * (y[-1] - y[0]), span, BASE]
        data = ((heights - low) / span).ravel()
        spec.add_hfield(name=GROUND, size=size, nrow=len(y), ncol=len(x), userdata=data)
        for geom in spec.worldbody.geoms:
            if geom.type == mujoco.mjtGeom.mjGEOM_PLANE:
                geom.type, geom.hfieldname = mujoco.mjtGeom.mjGEOM_HFIELD, GROUND
                geom.pos = [0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1]), low]

    def _touched(self, walker: int) -> Bool[np.ndarray, " point"]:
        """Returns which points are of feet that touched the ground as the step began."""
        contact, bodies = self._datas[walker].contact, self._models[walker].geom_bodyid
        pairs = np.asarray(contact.geom).reshape(-1, 2)[np.asarray(contact.exclude) == 0]
        floor = np.isin(pairs, self._floors[walker])
        own = set(bodies[pairs[floor[:, ::-1]]].tolist())
        found = np.zeros(len(self.anatomy.points), bool)
        for foot, points in self._feet_of:
            found[np.array(points)] = bool(own & foot)
        return found

    def _put(self, data: Any, place: Any, rate: Any) -> None:
        """Sets MuJoCo's positions and velocities from coordinates and their rates."""
        if self.anatomy.root.is_planar:
            data.qpos[:], data.qvel[:] = place, rate
            return
        turned, axes = _turned(place[3:6])
        attitude = turned @ self._tree.turn
        mujoco.mju_mat2Quat(data.qpos[3:FREE], attitude.ravel())
        data.qpos[:3], data.qpos[FREE:] = place[:3], place[6:]
        data.qvel[:], data.qvel[3:6] = rate, attitude.T @ axes @ rate[3:6]

    def _coordinates(self, data: Any) -> tuple[Any, Any]:
        """Returns coordinates and their rates of MuJoCo's positions and velocities."""
        if self.anatomy.root.is_planar:
            return data.qpos.copy(), data.qvel.copy()
        flat = np.zeros(9)
        mujoco.mju_quat2Mat(flat, data.qpos[3:FREE])
        attitude = flat.reshape(3, 3)
        at = attitude @ self._tree.turn.T
        pitch = np.arcsin(np.clip(-at[2, 0], -1.0, 1.0))
        euler = np.array([np.arctan2(at[1, 0], at[0, 0]), pitch, np.arctan2(at[2, 1], at[2, 2])])
        rate = data.qvel.copy()
        rate[3:6] = np.linalg.solve(_turned(euler)[1], attitude @ data.qvel[3:6])
        return np.concatenate([data.qpos[:3], euler, data.qpos[FREE:]]), rate


def _floors(model: Any) -> Any:
    """Returns the numbers of geoms that are the ground."""
    kinds = [int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD)]
    return np.flatnonzero(np.isin(model.geom_type, kinds) & (model.geom_bodyid == 0))


def _turned(euler: Any) -> tuple[Float[np.ndarray, "3 3"], Float[np.ndarray, "3 3"]]:
    """Returns the rotation of yaw, pitch and roll, and as columns the axes of the three."""
    (a, b, c), (x, y, z) = np.cos(euler), np.sin(euler)
    yaw = np.array([[a, -x, 0.0], [x, a, 0.0], [0.0, 0.0, 1.0]])
    pitch = np.array([[b, 0.0, y], [0.0, 1.0, 0.0], [-y, 0.0, b]])
    roll = np.array([[1.0, 0.0, 0.0], [0.0, c, -z], [0.0, z, c]])
    axes = np.stack([[0.0, 0.0, 1.0], yaw[:, 1], (yaw @ pitch)[:, 0]], axis=1)
    return yaw @ pitch @ roll, axes
