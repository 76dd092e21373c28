"""Any legged body of a MJCF file, with settings alone: no code knows the body."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Literal

import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float

from mjxwalk.envs import checks, dynamics, floating, mjcf_anatomy, mjcf_motors, mjcf_tree
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.fitness_terms import FitnessTerms, Seen, Tally
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.mjcf_source import geoms_of
from mjxwalk.envs.motor import Action, Springs
from mjxwalk.envs.observation import BodyObservation
from mjxwalk.envs.own_laws import Forbidden
from mjxwalk.envs.state import State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.trees import Instant
from mjxwalk.envs.trial import Trial, TrialState

# ours: shares of a body's weight, of the height of its root, and of the time that a fall from there
# takes, over the square root of two. Each is what let the first few bodies walk.
SINK = 0.004  # of four points of the feet that carry it, in heights
STOP_STIFFNESS = 4.0  # of joints' limits, in weights times heights a rad
STOP_TIME = 0.04  # of their damping over their stiffness
STEP = 0.011  # of the physics
SPEED = 0.28  # that is wanted
LEAST_SPEED = 0.14  # below which a walker falls behind
MOST_LAG = 2.0  # heights that it may fall behind
FLIGHT = 0.3  # without ground contact
# What a second at the wanted speed is worth, beside 1 for not falling, and costs: sideways, and by
# a cost of transport of 1.
DISTANCE_WORTH, DRIFT_COST, WORK_COST = 0.44, 0.26, 0.09
MOST_FRICTION = 1.0  # a file's feet may say more, and ground like that is rare
CLEARANCE = 0.05  # of a foot in the air, that is wanted
FINEST, COARSEST = 0.0005, 0.002  # s; of the physics


@dataclasses.dataclass(frozen=True, kw_only=True)
class MjcfEnv(LeggedEnv):
    """The body of a file, its ground, and the rules of a trial.

    What all bodies have is in `LeggedEnv`; what a file says is in `mjcf_tree.py`.

    Attributes:
      body: MJCF, in itself complete.
      start_angles: of the joints by name at the start, rad; of others the file says them.
      acting: what a policy's numbers from -1 to 1 are: "target" of joints about where they start,
        held by stiffness and damping, or "torque".
      gains: of motors that hold targets: "derived" from the body's weight and size, or those of the
        "file" where it has position actuators.
      min_height: of the root over the ground, as a share of that at the start; under it the walker
        has fallen.
      max_pitch: of the torso, rad; beyond it the walker has fallen.
      max_roll: of the torso, rad; beyond it the walker has fallen.
      max_yaw: of the torso, rad; beyond it the walker has fallen.
      joint_stop: law of the joints' limits.
      terms: what a walker is worth.
      forbidden: names of bodies that must not touch the ground; a walker of which one does has
        fallen.
    """

    body: str = dataclasses.field(repr=False)
    terrain: Any = SerpentineWalk()
    contact: SoftContact = SoftContact(stiffness=12_500.0, damping=625.0)  # ours: of some 10 kg
    joint_stop: JointStop = JointStop(stiffness=1_000.0, damping=10.0)  # ours: of some 10 kg
    # A table cannot be hashed; settings that differ in it alone may share a hash.
    start_angles: Mapping[str, float] = dataclasses.field(
        default_factory=dict[str, float], hash=False
    )
    acting: Literal["target", "torque"] = "target"
    gains: Literal["derived", "file"] = "derived"
    terms: FitnessTerms = FitnessTerms()
    forbidden: tuple[str, ...] = ()
    timestep: float = 0.001  # ours
    min_height: float = 0.75  # ours: a lower one lets crouchers win
    max_pitch: float = 0.8  # ours
    max_roll: float = 0.8  # ours
    max_yaw: float = 1.0  # ours: a walker that turns away from x does not come far
    max_flight_time: float = 0.1  # ours: a walker that flies does not walk
    min_speed: float = 0.1  # ours: far below any gait
    max_lag: float = 1.0  # ours: 10 s to set off
    torque_budget: float = 1e6  # ours: more than any trial spends
    max_time: float = 30.0  # ours

    def __post_init__(self) -> None:
        checks.positive(self, "min_height", "max_pitch", "max_roll", "max_yaw")
        for name, known in (("acting", ("target", "torque")), ("gains", ("derived", "file"))):
            if getattr(self, name) not in known:
                raise ValueError(
                    f'{name} must be "{known[0]}" or "{known[1]}", got "{getattr(self, name)}"'
                )
        super().__post_init__()
        _ = self._stance  # refuses a file that is no body
        names = [str(self.model.mujoco.body(body).name) for body in range(self.model.mujoco.nbody)]
        for name in self.forbidden:
            if name not in names:
                raise ValueError(f"forbidden names {name}, and the body has {', '.join(names[1:])}")
        _ = self.anatomy  # refuses motors that nothing here moves

    @classmethod
    def of(cls, text: str, **settings: Any) -> "MjcfEnv":
        """Returns the environment of a body, its settings derived from weight and size.

        Args:
          text: MJCF, in itself complete.
          settings: that are known already.

        Raises:
          ValueError: the text is no body that can be simulated, or a setting is wrong.
        """
        found = mjcf_anatomy.stance(text)
        height, weight, time = found.height, found.weight, found.time
        stiffness = weight / (4 * SINK * height)
        mass = weight / mjcf_anatomy.GRAVITY
        stop = STOP_STIFFNESS * weight * height
        pace = height / time
        derived: dict[str, Any] = {
            "contact": SoftContact(
                stiffness=_rounded(stiffness),
                damping=_rounded(np.sqrt(stiffness * mass / 4)),
                friction=_rounded(min(MOST_FRICTION, mjcf_tree.friction(text))),
            ),
            "joint_stop": JointStop(
                stiffness=_rounded(stop), damping=_rounded(STOP_TIME * time * stop)
            ),
            "timestep": float(np.clip(_rounded(STEP * time, 1), FINEST, COARSEST)),
            "max_flight_time": _rounded(FLIGHT * time),
            "min_speed": _rounded(LEAST_SPEED * pace),
            "max_lag": _rounded(MOST_LAG * height),
            "terms": FitnessTerms(
                speed=_rounded(SPEED * pace),
                clear_height=_rounded(CLEARANCE * height),
                distance=_rounded(DISTANCE_WORTH / (SPEED * pace)),
                drift=_rounded(-DRIFT_COST / (SPEED * pace)),
                work=_rounded(-WORK_COST * height / (SPEED * pace)),
            ),
        }
        return cls(body=text, **{**derived, **settings})

    @property
    def model(self) -> dynamics.Model:
        return mjcf_tree.of_text(self.body).hinged

    @property
    def floating(self) -> dynamics.Model | None:
        return mjcf_tree.of_text(self.body).floating

    @property
    def anatomy(self) -> Anatomy:
        return mjcf_anatomy.anatomy(self.body, self.acting, self.gains)

    def spec(self) -> Any:
        tree = mjcf_tree.of_text(self.body)
        return mjcf_motors.add(tree.spec.copy(), tree)

    @property
    def stop_law(self) -> JointStop:
        return self.joint_stop

    @property
    def springs(self) -> Sprung | None:
        model, joints = self.model.mujoco, slice(self.anatomy.root.num, None)
        stiffness, rest, damping = (
            np.array(values[joints], np.float32)
            for values in (model.jnt_stiffness, model.qpos_spring, model.dof_damping)
        )
        if not stiffness.any() and not damping.any():
            return None
        return Sprung(np.arange(len(rest)), Springs(stiffness, rest, damping))

    @property
    def friction(self) -> Float[np.ndarray, " joint"] | None:
        loss = self.model.mujoco.dof_frictionloss[self.anatomy.root.num :]
        return np.array(loss, np.float32) if loss.any() else None

    @property
    def max_tilt(self) -> dict[str, float]:
        limits = {"yaw": self.max_yaw, "pitch": self.max_pitch, "roll": self.max_roll}
        root = self.anatomy.root
        return {turn: most for turn, most in limits.items() if getattr(root, turn) is not None}

    @property
    def lowest_hips(self) -> float:
        return self.min_height * self._stance.height

    @property
    def leg_length(self) -> float:
        """From the root to the lowest point of the feet as it stands at the start, m."""
        return self._stance.height

    @property
    def walking_time(self) -> float:
        """Of a fall from the root's height, over the square root of two, s; gaits go by it."""
        return self._stance.time

    def start(self, given: Trial, /) -> State:
        """Returns a walker at rest, its lowest points as deep as its weight presses them."""
        stance, root = self._stance, self.anatomy.root
        depth = self.weight / (int(stance.touching.sum()) * self.contact.stiffness)
        zero = jnp.zeros(())
        ground = self.terrain.height(given.ground, zero, None if root.is_planar else zero)
        points = len(self.anatomy.points)
        return State(
            qpos=jnp.asarray(stance.qpos).at[root.height].add(ground - depth),
            qvel=jnp.zeros(len(stance.qpos)),
            stretch=jnp.zeros(points if root.is_planar else (points, 2)),
            touching=jnp.asarray(stance.touching),
            ankle_x=jnp.asarray(stance.ankle_x),
            trial=TrialState.begin(),
            own=self.terms.begin(
                legs=len(self.anatomy.legs),
                motors=len(self.anatomy.motors),
                watches=bool(self.forbidden),
            ),
        )

    def sense(self, state: State, /) -> BodyObservation:
        """Returns what the walker senses."""
        root = self.anatomy.root
        if root.is_planar:
            pitch = state.qpos[root.pitch]
            sine, cosine = jnp.sin(pitch), jnp.cos(pitch)
            x, z = state.qvel[:2]
            up = jnp.stack([-sine, cosine])
            turning = state.qvel[root.pitch : root.num]
            velocity = jnp.stack([cosine * x - sine * z, sine * x + cosine * z])
            heading = jnp.zeros(0)
        else:
            axes = floating.rotation(state.qpos[3:6])
            up, velocity = axes[2], state.qvel[:3] @ axes
            turning = floating.spin(state.qpos[3:6], state.qvel[3:6])
            heading = state.qpos[3:4]
        return BodyObservation(
            time=state.trial.num_steps * self.timestep,
            up=up,
            turning=turning,
            velocity=velocity,
            heading=heading,
            angle=state.qpos[root.num :],
            rate=state.qvel[root.num :],
            contact=self._standing(state),
            ankle_x=state.ankle_x,
        )

    def own_laws(self) -> dict[str, tuple[Any, ...]]:
        return {
            "fitness": (self.terms,),
            "is_low": (Forbidden(self.forbidden, self._forbidden_radii),),
        }

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns what the terms come to."""
        terms, trial, root = self.terms, state.trial, self.anatomy.root
        seconds = trial.num_steps * self.timestep
        far = state.qpos[root.forward]
        if terms.speed:
            far = jnp.minimum(far, terms.speed * seconds)
        usual = self.weight * self._stance.height
        worth = terms.distance * far + terms.alive * seconds
        if root.sideways is not None:
            worth += terms.drift * jnp.abs(state.qpos[root.sideways])
        worth += terms.work * trial.work / usual + terms.torque * trial.torque_cost / usual
        return worth + terms.worth(state.own)

    def carry_on(self, state: State, moved: State, now: Instant, action: Any, given: Trial) -> Any:
        """Returns what terms and ends have counted after a step."""
        del moved
        tally: Tally = state.own
        if all(part is None for part in tally):
            return tally
        strength = np.array([each.strength for each in self.anatomy.motors], np.float32)
        seen = Seen(
            self.sense(state),
            (action.target + action.torque) / strength,
            None if tally.clear is None else self._clear(state, now, given),
            None if tally.forbidden is None else self._touches(state, now, given),
        )
        return self.terms.count(tally, seen, seconds=self.timestep)

    def is_low(self, state: State, ground: Float[Array, ""] | float, /) -> Bool[Array, ""]:
        """Returns whether the root is too low, or a body touches the ground that must not."""
        low = super().is_low(state, ground)
        return low if state.own.forbidden is None else low | state.own.forbidden

    def low_words(self) -> str:
        """Returns what `is_low` means, for someone who asks why a walker fell."""
        words = f"the torso lower than {self.lowest_hips:.2g} m"
        return (
            f"{words}, or {' or '.join(self.forbidden)} on the ground" if self.forbidden else words
        )

    def _clear(self, state: State, now: Instant, given: Trial) -> Float[Array, " leg"]:
        """Returns how high feet are over the ground below them, more than at the start, m."""
        feet = self._places(state, now, self._feet)
        ground = self._grounds(given, feet)
        return feet[:, 2] - ground - np.array(self._stance.feet, np.float32)

    def _touches(self, state: State, now: Instant, given: Trial) -> Bool[Array, ""]:
        """Returns whether a forbidden body's sphere touches the ground."""
        places = self._places(state, now, self.forbidden)
        radii = np.array(self._forbidden_radii, np.float32)
        return jnp.any(places[:, 2] - radii < self._grounds(given, places))

    @property
    def _forbidden_radii(self) -> tuple[float, ...]:
        """Of spheres at bodies' origins; ours: half of that about a body's largest geom, m."""
        model = self.model.mujoco
        geoms = [geoms_of(model, model.body(name).id) for name in self.forbidden]
        return tuple(0.5 * max(model.geom_rbound[own], default=0.0) for own in geoms)

    def _places(self, state: State, now: Instant, names: tuple[str, ...]) -> Float[Array, "body 3"]:
        """Returns where bodies are in the world, m."""
        places = self._tree.bodies(now, names)
        if now.axes is None:
            root = jnp.stack([state.qpos[0], jnp.zeros(()), state.qpos[1]])
            return places + root
        return state.qpos[:3] + places @ now.axes.T

    def _grounds(self, given: Trial, places: Float[Array, "body 3"]) -> Float[Array, " body"]:
        planar = self.anatomy.root.is_planar
        heights = [self.ground_height(given, x, None if planar else y) for x, y, _ in places]
        return jnp.stack(heights)

    def scaled_action(self, values: Float[Array, " motor"], /) -> Action:
        """Returns the action of numbers from -1 to 1, one for each motor."""
        motors = self.anatomy.motors
        strength, centre, damping, stiffness = (
            jnp.asarray(np.array([getattr(each, name) for each in motors], np.float32))
            for name in ("strength", "centre", "damping", "stiffness")
        )
        asked = strength * jnp.clip(values, -1.0, 1.0)
        nothing = jnp.zeros_like(values)
        if self.acting == "torque":
            return Action(asked, nothing, nothing, damping)
        ends = [self.anatomy.coordinates[each.coordinate] for each in motors]
        lower, upper = (
            np.array([getattr(each, end) for each in ends], np.float32)
            for end in ("lower", "upper")
        )
        return Action(nothing, jnp.clip(centre + asked, lower, upper), stiffness, damping)

    def _standing(self, state: State) -> Bool[Array, " leg"]:
        anatomy = self.anatomy
        return jnp.stack(
            [jnp.any(state.touching[np.array(anatomy.points_of(leg))]) for leg in anatomy.legs]
        )

    @property
    def _stance(self) -> mjcf_anatomy.Stance:
        return mjcf_anatomy.stance(self.body, tuple(sorted(self.start_angles.items())))


def _rounded(value: float, digits: int = 2) -> float:
    """Returns a number with so many digits, so that settings are read easily."""
    return float(f"{value:.{digits}g}")
