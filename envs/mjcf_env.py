"""Any legged body of a MJCF file, with settings alone: no code knows the body."""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, PRNGKeyArray

from mjxwalk.envs import body_heights, checks, dynamics, edge, motor, observation
from mjxwalk.envs.anatomy import Anatomy
from mjxwalk.envs.contact import SoftContact
from mjxwalk.envs.derived import anatomy as mjcf_anatomy
from mjxwalk.envs.derived import defaults, file_tree
from mjxwalk.envs.derived import motors as mjcf_motors
from mjxwalk.envs.fitness_terms import FitnessTerms, Seen, Tally
from mjxwalk.envs.joint_stop import JointStop
from mjxwalk.envs.legged import LeggedEnv
from mjxwalk.envs.legged_body import Sprung
from mjxwalk.envs.motor import Action, Springs
from mjxwalk.envs.mujoco_law import law
from mjxwalk.envs.mujoco_law.forward import MujocoState
from mjxwalk.envs.mujoco_law.settings import MujocoContact
from mjxwalk.envs.observation import BodyObservation
from mjxwalk.envs.own_laws import Forbidden
from mjxwalk.envs.state import State
from mjxwalk.envs.surface import SerpentineWalk
from mjxwalk.envs.trees import Instant
from mjxwalk.envs.trial import Trial, Trials, TrialState

LONGEST_STEP = 0.2  # of a fall from the root's height, over the square root of two; ours
START = 0x73746172  # folded into the key of the random ground


class Own(NamedTuple):
    """What a body of a file carries beside its coordinates.

    Attributes:
      tally: what terms and ends have counted.
      mujoco: what MuJoCo carries under its contact law; None under the other.
    """

    tally: Tally
    mujoco: MujocoState | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class MjcfEnv(LeggedEnv):
    """The body of a file, its ground, and the rules of a trial.

    What all bodies have is in `LeggedEnv`; what a file says is in `file_tree.py`.

    Attributes:
      body: MJCF, in itself complete.
      start_angles: of the joints by name at the start, rad; of others the file says them.
      contact_law: "points" for springs, dampers and friction at points of the feet, or "mujoco" for
        MuJoCo's contacts of all geoms and its constraint solver.
      solver: of the contact law "mujoco".
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
      perturbation: of the starts of trials, as a share of `START_DEPARTURES`.
      forbidden: names of bodies that must not touch the ground; a walker of which one does has
        fallen.
    """

    START_DEPARTURES: ClassVar = {
        # In what it walks at, were its legs pendulums: the square root of gravity times height.
        "tipping_forward": 0.07,  # ours: as `Planar7`'s push
        "tipping_sideways": 0.03,  # ours: twice `Flame`'s push; none in the plane
    }

    body: str = dataclasses.field(repr=False)
    terrain: Any = SerpentineWalk()
    contact: SoftContact = SoftContact(stiffness=12_500.0, damping=625.0)  # ours: of some 10 kg
    joint_stop: JointStop = JointStop(stiffness=1_000.0, damping=10.0)  # ours: of some 10 kg
    # A table cannot be hashed; settings that differ in it alone may share a hash.
    start_angles: Mapping[str, float] = dataclasses.field(
        default_factory=dict[str, float], hash=False
    )
    contact_law: Literal["points", "mujoco"] = "points"
    solver: MujocoContact = MujocoContact()
    acting: Literal["target", "torque"] = "target"
    gains: Literal["derived", "file"] = "derived"
    terms: FitnessTerms = FitnessTerms()
    perturbation: float = 0.0
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
        checks.not_negative(self, "perturbation")
        checks.positive(self, "min_height", "max_pitch", "max_roll", "max_yaw")
        checks.one_of(self, "contact_law", ("points", "mujoco"))
        checks.one_of(self, "acting", ("target", "torque"))
        checks.one_of(self, "gains", ("derived", "file"))
        if self.min_height >= 1.0:
            raise ValueError(
                f"min_height must be below 1, at which trials start, got {self.min_height:g}"
            )
        super().__post_init__()
        longest = LONGEST_STEP * self.stance.time  # stance refuses a file that is no body
        if self.timestep > longest:
            raise ValueError(
                f"timestep must be at most {longest:.2g} s, in which a body of this size falls "
                f"visibly, got {self.timestep:g}"
            )
        names = [str(self.model.mujoco.body(body).name) for body in range(self.model.mujoco.nbody)]
        for name in self.forbidden:
            if name not in names:
                raise ValueError(f"forbidden names {name}, and the body has {', '.join(names[1:])}")
        if self._is_mujocos:
            law.model_of(self)  # refuses what MJX cannot compute
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
        derived = defaults.of_text(text, contact_law=settings.get("contact_law", "points"))
        return cls(body=text, **{**derived, **settings})

    def equipped(self, key: PRNGKeyArray, trials: Trials) -> Trials:
        """Returns trials with what the settings add to the random ground; see `LeggedEnv`."""
        trials = super().equipped(key, trials)
        if not self.perturbation:
            return trials
        _, trials = self.perturbed(jax.random.fold_in(key, START), trials)
        return trials._replace(start=self.perturbation * trials.start)

    @edge.takes_arrays
    def step(self, state: State, action: Any, given: Trial) -> State:
        """Returns the walker one physics step later, and whether its trial is over."""
        if not self._is_mujocos:
            return super().step(state, action, given)
        self._check_action(action)
        action = self._full(action)
        moved = law.step(self, state, action, given)
        tally = self.carry_on(state, moved, self._tree.see(state), action, given).tally
        moved = moved._replace(own=moved.own._replace(tally=tally))
        return self._judged(state, moved, given)

    def ground_forces(self, state: State, given: Trial) -> Float[Array, "point 3"]:
        """Returns the ground's force on each contact point, N; a foot's is shared by its points."""
        if not self._is_mujocos:
            return super().ground_forces(state, given)
        idle = self._full(jnp.zeros(len(self.anatomy.motors)))
        return law.ground_forces(self, state, idle, given)

    @property
    def _is_mujocos(self) -> bool:
        return self.contact_law == "mujoco"

    @property
    def model(self) -> dynamics.Model:
        return file_tree.of_text(self.body).hinged

    @property
    def floating(self) -> dynamics.Model | None:
        return file_tree.of_text(self.body).floating

    @property
    def anatomy(self) -> Anatomy:
        return mjcf_anatomy.anatomy(self.body, self.acting, self.gains)

    def spec(self) -> Any:
        tree = file_tree.of_text(self.body)
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
        return Sprung(np.arange(len(rest), dtype=np.int32), Springs(stiffness, rest, damping))

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
        return self.min_height * self.stance.height

    @property
    def leg_length(self) -> float:
        """From the root to the lowest point of the feet as it stands at the start, m."""
        return self.stance.height

    @property
    def walking_time(self) -> float:
        """Of a fall from the root's height, over the square root of two, s; gaits go by it."""
        return self.stance.time

    def start(self, given: Trial, /) -> State:
        """Returns a walker whose lowest points are as deep as its weight presses them.

        It is at rest, or tips about its soles as the trial's start says.
        """
        stance, root = self.stance, self.anatomy.root
        depth = self.weight / (int(stance.touching.sum()) * self.contact.stiffness)
        zero = jnp.zeros(())
        ground = self.terrain.height(given.ground, zero, None if root.is_planar else zero)
        points = len(self.anatomy.points)
        qpos = jnp.asarray(stance.qpos).at[root.height].add(ground - depth)
        tally = self.terms.begin(
            legs=len(self.anatomy.legs),
            motors=len(self.anatomy.motors),
            watches=bool(self.forbidden),
        )
        qvel = self._tipping(given.start)
        return State(
            qpos=qpos,
            qvel=qvel,
            stretch=jnp.zeros(points if root.is_planar else (points, 2)),
            touching=jnp.asarray(stance.touching),
            ankle_x=jnp.asarray(stance.ankle_x),
            trial=TrialState.begin(),
            own=Own(tally, law.begin(self, qpos, qvel) if self._is_mujocos else None),
        )

    def sense(self, state: State, /) -> BodyObservation:
        """Returns what the walker senses."""
        return observation.of_body(
            state,
            self.anatomy.root,
            contact=self._standing(state),
            time=state.trial.num_steps * self.timestep,
        )

    def own_laws(self) -> dict[str, tuple[Any, ...]]:
        return {
            "step": (),  # under contact law points it is that of all bodies
            "fitness": (self.terms,),
            "is_low": (Forbidden(self.forbidden, body_heights.forbidden_radii(self)),),
        }

    def fitness(self, state: State, /) -> Float[Array, ""]:
        """Returns what the terms come to."""
        usual = self.weight * self.stance.height
        return self.terms.total(state, self.anatomy.root, usual=usual, timestep=self.timestep)

    def carry_on(self, state: State, moved: State, now: Instant, action: Any, given: Trial) -> Any:
        """Returns what terms and ends have counted after a step."""
        del moved
        tally: Tally = state.own.tally
        if all(part is None for part in tally):
            return state.own
        strength = np.array([each.strength for each in self.anatomy.motors], np.float32)
        seen = Seen(
            self.sense(state),
            (action.target + action.torque) / strength,
            None if tally.clear is None else body_heights.clear(self, state, now, given),
            None if tally.forbidden is None else body_heights.touches(self, state, now, given),
        )
        return state.own._replace(tally=self.terms.count(tally, seen, seconds=self.timestep))

    def is_low(self, state: State, ground: Float[Array, ""] | float, /) -> Bool[Array, ""]:
        """Returns whether the root is too low, or a body touches the ground that must not."""
        low = super().is_low(state, ground)
        return low if state.own.tally.forbidden is None else low | state.own.tally.forbidden

    def low_words(self) -> str:
        """Returns what `is_low` means, for someone who asks why a walker fell."""
        words = f"the torso lower than {self.lowest_hips:.2g} m"
        return (
            f"{words}, or {' or '.join(self.forbidden)} on the ground" if self.forbidden else words
        )

    def scaled_action(self, values: Float[Array, " motor"], /) -> Action:
        """Returns the action of numbers from -1 to 1, one for each motor."""
        return motor.scaled(self.anatomy, values, acting=self.acting)

    def _tipping(self, draws: Float[Array, " departure"] | None) -> Float[Array, " coordinate"]:
        """Returns the velocities of a start by its draws from -1 to 1; at rest without."""
        qvel = jnp.zeros(len(self.stance.qpos))
        if draws is None:
            return qvel
        root, pace = self.anatomy.root, self.stance.height / self.stance.time
        forward, sideways = (pace * most for most in self.START_DEPARTURES.values())
        lean = forward * draws[0]
        qvel = qvel.at[root.forward].set(lean).at[root.pitch].set(lean / self.stance.height)
        if root.sideways is None:
            return qvel
        lean = sideways * draws[1]
        return qvel.at[root.sideways].set(lean).at[root.roll].set(-lean / self.stance.height)

    def _standing(self, state: State) -> Bool[Array, " leg"]:
        anatomy = self.anatomy
        return jnp.stack(
            [jnp.any(state.touching[np.array(anatomy.points_of(leg))]) for leg in anatomy.legs]
        )

    @property
    def stance(self) -> mjcf_anatomy.Stance:
        """How it stands as trials start."""
        return mjcf_anatomy.stance(self.body, tuple(sorted(self.start_angles.items())))
