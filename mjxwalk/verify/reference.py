"""Bodies in C MuJoCo, float64, stepped with forces that are worked out anew.

Independent of the engines: kinematics, axes of motion, bias forces and mass matrix are C MuJoCo's,
other laws those of `laws`, and accelerations come from a dense solve. Shared with them is what an
environment says of its body: its `mujoco.MjSpec`, its anatomy, its settings, and its own laws.
"""

from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from mjxwalk.envs import Action, LeggedEnv, Trials, VelocityMotor
from mjxwalk.envs.own_laws import Righting, TorsoLoad
from mjxwalk.verify import laws, pushes_and_payloads
from mjxwalk.verify.herd import torque_limits
from mjxwalk.verify.laws import GroundForce
from mjxwalk.verify.stepping import Balance, Step

GRAVITY = np.array([0.0, 0.0, -9.81])  # m/s^2


class Reference:
    """Walkers of one body, each on a ground of its own.

    C MuJoCo moves them all in a call; what Python does, it does with arrays of all of them.

    Attributes:
      env: body, ground and step.
      anatomy: of the body.
      own_laws: of the body.
      herd: the walkers in C MuJoCo.
      heights: of each walker's random ground [walker, *node], m.
      course: what lies on it [walker, node, channel]; None where nothing does.
      load: what each draws of its largest load, from -1 to 1; None of those without.
      pushes: when each walker's begin and what they give; None of those without.
      limits: least and greatest torque of each motor, N m; infinite where it has none.
      qpos: of the coordinates [walker, coordinate], m and rad; replaced by every step.
      qvel: their rates; replaced by every step.
      stretch: of the ground's tangential springs, m.
    """

    def __init__(self, env: LeggedEnv, qpos: Any, qvel: Any, trials: Trials) -> None:
        """Places walkers.

        Args:
          env: body, ground and step.
          qpos: coordinates [walker, coordinate], m and rad.
          qvel: their rates.
          trials: one of each walker; where it starts is in the coordinates.
        """
        self.env, self.anatomy, self.own_laws = env, env.anatomy, env.own_laws()
        anatomy, self._num_steps = self.anatomy, 0
        self.heights = np.asarray(trials.heights, np.float64)
        self.course, self.load, self.pushes = (
            None if part is None else np.asarray(part, np.float64)
            for part in (trials.course, trials.load, trials.push)
        )
        self.herd = pushes_and_payloads.herd(env, self.load, len(qpos))
        self._own = pushes_and_payloads.Own(env)
        self.qpos, self.qvel = (np.array(each, np.float64) for each in (qpos, qvel))
        self.stretch = np.zeros(
            (self.herd.num, len(anatomy.points), 1 if anatomy.root.is_planar else 2)
        )
        self._joints = list(anatomy.joint_coordinate)
        self._tie = np.eye(len(anatomy.coordinates))[self._joints]
        self._driven = anatomy.driven
        self.limits = torque_limits(self.herd.model, anatomy.first_joint[self._driven].tolist())
        self._ranges = np.array([(each.lower, each.upper) for each in anatomy.coordinates])
        touching = [point.body for point in anatomy.points]
        self._touching, self._moves = self.herd.ids(*touching), self.herd.moves(*touching)
        self._feet = self.herd.ids(*(leg.foot for leg in anatomy.legs))
        self._torso, self._carries = self.herd.ids(anatomy.torso), self.herd.moves(anatomy.torso)

    def step(self, action: Any, walking: Bool[np.ndarray, " walker"] | None = None) -> Step:
        """Moves walkers on by one step.

        Args:
          action: that of the motors' law, numpy arrays [walker, motor].
          walking: who moves; None for all.
        """
        herd = self.herd
        herd.qpos[:], herd.qvel[:] = self.qpos[:, self._joints], self.qvel[:, self._joints]
        herd.see()
        balance = Balance(herd.mass(), -herd.of_joints("qfrc_bias"))
        push = self._ground(balance)
        self._springs(balance)
        self._pushed(balance)
        self._of_its_own(balance)
        mass = self._tie.T @ balance.mass @ self._tie
        force = balance.force @ self._tie
        self._stops(mass, force)
        acceleration, torque = self._drive(mass, force, action)
        rates = self.qvel + self.env.timestep * acceleration
        on = np.ones(herd.num, bool) if walking is None else walking
        self.qvel = np.where(on[:, None], rates, self.qvel)
        self.qpos = np.where(on[:, None], self.qpos + self.env.timestep * rates, self.qpos)
        self.stretch = np.where(on[:, None, None], push.stretch, self.stretch)
        self._num_steps += 1
        feet = herd.data.xpos[self._feet]
        return Step(push, feet, herd.centre().copy(), torque, rates[:, self._driven])

    def places(self, *names: str) -> Float[np.ndarray, "walker body 3"]:
        """Returns where bodies were as the last step began, m."""
        return self.herd.data.xpos[self.herd.ids(*names)]

    def over_ground(self, places: Any) -> Float[np.ndarray, "walker body"]:
        """Returns how high places [walker, body, 3] are over the ground below them, m."""
        x, y, z = np.moveaxis(places, -1, 0)
        ground = laws.height(self.env.terrain, self.heights, x, y)
        return z - ground - laws.lying(self.env.course, self.course, x).height

    def height(self, qpos: Any) -> Float[np.ndarray, " walker"]:
        """Returns the ground's height under the hips of such coordinates, m."""
        root = self.anatomy.root
        x = qpos[:, root.forward]
        y = np.zeros_like(x) if root.sideways is None else qpos[:, root.sideways]
        ground = laws.height(self.env.terrain, self.heights, x, y)
        return ground + laws.lying(self.env.course, self.course, x).height

    def _ground(self, balance: Balance) -> GroundForce:
        """Adds what the ground does, and returns it."""
        points = self._points()
        jacobian = self.herd.jacobian(points, self._moves)
        course = laws.lying(self.env.course, self.course, points[..., 0])
        push = laws.ground_force(
            self.env.contact,
            -self.over_ground(points),
            (jacobian @ self.herd.qvel[:, None, :, None])[..., 0],
            self.stretch,
            timestep=self.env.timestep,
            implicit=self.env.implicit,
            course=course,
        )
        self._put_on(balance, points, jacobian, push.force, push.mass)
        return push

    def _points(self) -> Float[np.ndarray, "walker point 3"]:
        """Returns where the ground could touch the walkers: points, or the lowest of spheres."""
        points = self.anatomy.points
        offsets = np.array([point.offset for point in points])[:, :, None]
        turned = self.herd.data.xmat[self._touching].reshape(*self._touching.shape, 3, 3) @ offsets
        places = self.herd.data.xpos[self._touching] + turned[..., 0]
        places[..., 2] -= np.array([point.radius for point in points])
        return places

    def _put_on(self, balance: Balance, points: Any, jacobian: Any, force: Any, mass: Any) -> None:
        """Adds forces on points, and point masses that resist what accelerates them.

        They resist accelerations up to terms of the rates squared, which depend on the coordinates:
        environments take the torso's angular acceleration for one, where Jacobians here have the
        angles of its joints.
        """
        if not self.anatomy.root.is_planar:
            arms = self._arms(points)
            turning = np.broadcast_to(self._turning()[:, None], arms.shape)
            force = force - mass[..., None] * _cross(turning, arms)
        flat = jacobian.reshape(self.herd.num, -1, jacobian.shape[-1])
        transposed = np.swapaxes(flat, 1, 2)
        weighted = np.repeat(mass, 3, axis=1)[..., None] * flat
        balance.force[:] += (transposed @ force.reshape(self.herd.num, -1, 1))[..., 0]
        balance.mass[:] += transposed @ weighted

    def _arms(self, points: Any) -> Any:
        """Returns where points are from the torso, m."""
        return points - self.herd.data.xpos[self._torso]

    def _turning(self) -> Float[np.ndarray, "walker 3"]:
        """Returns the torso's angular acceleration at constant rates of its joints, rad/s^2."""
        num = self.anatomy.root.num
        changes = self.herd.data.cdof_dot.reshape(self.herd.num, -1, 6)[:, :num, :3]
        return (self.herd.qvel[:, None, :num] @ changes)[:, 0]

    def _springs(self, balance: Balance) -> None:
        """Adds the springs, dampers and dry friction of the model's joints."""
        model, dt, rates = self.herd.model, self.env.timestep * self.env.implicit, self.herd.qvel
        drag = laws.friction_damping(model.dof_frictionloss, rates)
        balance.force[:] += self.herd.of_joints("qfrc_passive") - drag * rates
        balance.force[:] -= dt * model.jnt_stiffness * rates
        resisting = model.dof_damping + drag + dt * model.jnt_stiffness
        joints = np.arange(model.nv)
        balance.mass[:, joints, joints] += dt * resisting

    def _pushed(self, balance: Balance) -> None:
        """Adds the forces of pushes, which act on the torso's own centre of mass."""
        if self.pushes is None or not self.env.push:
            return
        force = pushes_and_payloads.force(self.env, self._own, self.pushes, self._num_steps)
        points = self._on_torso(self._own.centre)
        jacobian = self.herd.jacobian(points, self._carries)
        balance.force[:] += (force[:, None] @ jacobian[:, 0])[:, 0]

    def _on_torso(self, place: Any) -> Float[np.ndarray, "walker 1 3"]:
        """Returns where a point of the torso is, m, of its place in the torso's axes."""
        torso = self._torso[:, 0]
        axes = self.herd.data.xmat[torso].reshape(-1, 3, 3)
        return (self.herd.data.xpos[torso] + axes @ place)[:, None]

    def _of_its_own(self, balance: Balance) -> None:
        """Adds what only this body has."""
        for law in (*self.own_laws.get("drive", ()), *self.own_laws.get("carried", ())):
            match law:
                case Righting():
                    self._right(balance, law)
                case TorsoLoad():
                    self._carry(balance, law)
                case _:
                    pass  # the motors'

    def _right(self, balance: Balance, law: Righting) -> None:
        """Adds what turns the torso's vertical to the world's."""
        if not (law.stiffness or law.damping):
            return
        dt = self.env.timestep * self.env.implicit
        axes = self.herd.data.xmat[self._torso[:, 0]].reshape(-1, 3, 3)  # as columns
        turns = self.herd.axes()[:, :, :3] * self._carries[0].T  # of the torso, by each joint
        own = np.swapaxes(turns @ axes, 1, 2)  # about its own axes
        spin = (own @ self.herd.qvel[..., None])[..., 0]
        # The cross product of both verticals is as long as the sine of the angle between them.
        off = (_cross(axes[:, :, 2], np.array([0.0, 0.0, 1.0]))[:, None] @ axes)[:, 0]
        off[:, 1] += np.sin(law.lean)
        share = np.array([law.roll, 1.0, 0.0])
        damping = law.damping + dt * law.stiffness
        resisting = dt * damping * share
        changing = (self._turning()[:, None] @ axes)[:, 0]
        torque = share * (law.stiffness * off - damping * spin) - resisting * changing
        balance.force[:] += (torque[:, None] @ own)[:, 0]
        balance.mass[:] += np.swapaxes(own, 1, 2) @ (resisting[:, None] * own)

    def _carry(self, balance: Balance, law: TorsoLoad) -> None:
        """Adds what the torso carries: its weight, its inertia, and what holds it on its curve."""
        if self.load is None or not law.mass:
            return
        mass = (law.mass * self.load)[:, None]
        points = self._on_torso(np.array(law.offset))
        spin = self.herd.data.cvel[self._torso, :3]
        curving = _cross(spin, _cross(spin, self._arms(points)))
        jacobian = self.herd.jacobian(points, self._carries)
        self._put_on(balance, points, jacobian, mass[..., None] * (GRAVITY - curving), mass)

    def _stops(self, mass: Any, force: Any) -> None:
        """Adds the joints' stops, which act on coordinates."""
        torque, inertia = laws.stop_torque(
            self.env.stop_law,
            self.qpos,
            self.qvel,
            self._ranges,
            timestep=self.env.timestep,
            implicit=self.env.implicit,
        )
        force += torque
        every = np.arange(force.shape[1])
        mass[:, every, every] += inertia

    def _drive(self, mass: Any, force: Any, action: Any) -> tuple[Any, Any]:
        """Returns the coordinates' accelerations, and the motors' torques, N m."""
        for law in self.own_laws.get("drive", ()):
            if isinstance(law, VelocityMotor):
                return self._driven_to_velocities(law, mass, force, *action)
        return self._driven_by_torques(mass, force, Action(*action))

    def _driven_by_torques(self, mass: Any, force: Any, action: Action) -> tuple[Any, Any]:
        """Returns the same of motors that give the torques that they are asked for."""
        dt, motors = self.env.timestep * self.env.implicit, self._driven
        angle, rate = self.qpos[:, motors], self.qvel[:, motors]
        asked = laws.motor_torque(action, angle, rate, dt)
        limited = np.clip(asked, *self.limits.T)
        force[:, motors] += limited
        added = dt * (np.asarray(action.damping) + dt * np.asarray(action.stiffness))
        # A motor at its limit does not yield to what the step brings.
        mass[:, motors, motors] += np.where(limited == asked, added, 0.0)
        acceleration = _solved(mass, force)
        rate = rate + dt * acceleration[:, motors]
        gave = laws.motor_torque(action, angle, rate, dt)
        return acceleration, np.where(limited == asked, gave, limited)

    def _driven_to_velocities(
        self, law: VelocityMotor, mass: Any, force: Any, target: Any
    ) -> tuple[Any, Any]:
        """Returns the same of motors that give what a velocity takes, at the end of the step."""
        dt, motors = self.env.timestep, self._driven
        units = np.broadcast_to(np.eye(mass.shape[-1])[:, motors], (*force.shape, len(motors)))
        solved = np.linalg.solve(mass, np.concatenate([force[..., None], units], axis=2))
        coasting, answer = solved[..., 0], solved[..., 1:]
        wanted = laws.requested(law, target - self.qpos[:, motors])
        wanted = wanted - self.qvel[:, motors] - dt * coasting[:, motors]
        torque = laws.velocity_torque(law, wanted, dt * answer[:, motors], self.limits)
        return coasting + (answer @ torque[..., None])[..., 0], torque


def _solved(mass: Any, force: Any) -> Any:
    return np.linalg.solve(mass, force[..., None])[..., 0]


def _cross(one: Any, other: Any) -> Any:
    """Returns cross products, some times as fast as NumPy's for few vectors."""
    (a, b, c), (x, y, z) = np.moveaxis(one, -1, 0), np.moveaxis(other, -1, 0)
    return np.stack([b * z - c * y, c * x - a * z, a * y - b * x], axis=-1)
