"""What a policy sees and moves, as plain data: senses and motors of a body, and their mirror."""

import dataclasses
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

GRAVITY = 9.81  # m/s^2, as in MuJoCo
# ours: what brings senses to about -1 ... 1, in radians, and in lengths and times of the body.
ROTATION, SPEED, RATE = 5.0, 1.0, 10.0  # rad/s, m/s and rad/s of a body of 1 m and its time


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """The senses that a policy reads and the motors that it moves.

    Of a body with sides each has a mirror partner.

    Attributes:
      inputs: names of the senses.
      places: of the senses in the observation, its fields one after the other.
      centre: what is taken off each.
      scale: what each is then divided by.
      input_mirror: place of each sense's partner, of left and right changed; () without sides.
      input_sign: that the partner's value is multiplied by.
      outputs: names of the motors that are moved.
      motors: their places in an action.
      output_mirror: place of each motor's partner among them.
      output_sign: that the partner's value is multiplied by.
      num_motors: of an action.
      lift: of each motor moved, how much of its range lifts its leg, as a leg swings: hip forward,
        knee bent, foot level; 0 of others.
      time: that a fall from the height of the root needs, over the square root of two, s.
      every: steps of the physics from one action to the next.
      timed: whether the observation says the time, as `time`.
    """

    inputs: tuple[str, ...] = ()
    places: tuple[int, ...] = ()
    centre: tuple[float, ...] = ()
    scale: tuple[float, ...] = ()
    input_mirror: tuple[int, ...] = ()
    input_sign: tuple[float, ...] = ()
    outputs: tuple[str, ...] = ()
    motors: tuple[int, ...] = ()
    output_mirror: tuple[int, ...] = ()
    output_sign: tuple[float, ...] = ()
    num_motors: int = 0
    lift: tuple[float, ...] = ()
    time: float = 0.3
    every: int = 1
    timed: bool = True

    @property
    def sides(self) -> int:
        """Two, left and right, or one where everything is a policy's own."""
        return 2 if self.input_mirror else 1

    def read(self, observation: Any) -> Float[Array, " input"]:
        """Returns the scaled senses of an observation."""
        parts = [jnp.ravel(leaf).astype(jnp.float32) for leaf in jax.tree.leaves(observation)]
        seen = jnp.concatenate(parts)[np.array(self.places)]
        centre, scale = (np.array(each, np.float32) for each in (self.centre, self.scale))
        return (seen - centre) * (1.0 / scale)

    def mirrored(self, inputs: Float[Array, " input"]) -> Float[Array, " input"]:
        """Returns the senses of the walker seen in a mirror."""
        return inputs[np.array(self.input_mirror)] * np.array(self.input_sign, np.float32)

    def action(self, outputs: Float[Array, " output"]) -> Float[Array, " motor"]:
        """Returns numbers from -1 to 1 for all motors; those not moved have 0."""
        return jnp.zeros(self.num_motors).at[np.array(self.motors)].set(outputs)


def of_task(env: Any) -> Layout:
    """Returns the layout of an environment whose observation is an array of numbers.

    Raises:
      ValueError: it does not name its observations and actions.
    """
    names = [getattr(env, f"{kind}_names", ()) for kind in ("observation", "action")]
    if not all(names):
        raise ValueError(
            f"{type(env).__name__} must have observation_names and action_names, or be of a body's "
            "file, for a policy to know what it sees and moves"
        )
    seen, moved = names
    return Layout(
        inputs=tuple(seen),
        places=tuple(range(len(seen))),
        centre=(0.0,) * len(seen),
        scale=(1.0,) * len(seen),
        outputs=tuple(moved),
        motors=tuple(range(len(moved))),
        num_motors=len(moved),
        lift=(0.0,) * len(moved),
        timed=False,
    )


def of_body(env: Any, *, moved: str, rates: bool, period: float) -> Layout:
    """Returns the layout of a body that is given by its file.

    Args:
      env: an `MjcfEnv`.
      moved: "legs" for the motors of its legs, which then are all that is read of its joints, or
        "all".
      rates: whether the rates of joints are read.
      period: from one action to the next, s.
    """
    from mjxwalk.envs.derived import anatomy as mjcf_anatomy
    from mjxwalk.envs.derived import file_tree

    anatomy, tree = env.anatomy, file_tree.of_text(env.body)
    stance, root = mjcf_anatomy.stance(env.body), anatomy.root
    of_legs = {
        root.num + place
        for place, joint in enumerate(tree.joints)
        for leg in tree.legs
        if joint.joint in leg.joints
    }
    motors = [
        place
        for place, motor in enumerate(anatomy.motors)
        if moved == "all" or motor.coordinate in of_legs
    ]
    chosen = {anatomy.motors[place].coordinate for place in motors}
    inputs = _inputs(anatomy, stance, chosen, rates)
    names = [each[0] for each in inputs]
    coordinates = [anatomy.motors[place].coordinate for place in motors]
    partners = [anatomy.coordinates[each].mirror for each in coordinates]
    return Layout(
        inputs=tuple(names),
        places=tuple(each[1] for each in inputs),
        centre=tuple(float(each[2]) for each in inputs),
        scale=tuple(float(each[3]) for each in inputs),
        input_mirror=tuple(names.index(each[4]) for each in inputs),
        input_sign=tuple(float(each[5]) for each in inputs),
        outputs=tuple(anatomy.motors[place].name for place in motors),
        motors=tuple(motors),
        output_mirror=tuple(coordinates.index(each) for each in partners),
        output_sign=tuple(anatomy.coordinates[each].sign for each in coordinates),
        num_motors=len(anatomy.motors),
        lift=_lift(anatomy, tree, stance, coordinates),
        time=float(stance.time),
        every=max(1, round(period / env.timestep)),
    )


def _inputs(anatomy: Any, stance: Any, chosen: set[int], rates: bool) -> list[tuple[Any, ...]]:
    """Returns name, place, centre, scale, partner's name and sign of each sense that is read."""
    found: list[tuple[Any, ...]] = []
    place = 0
    names = anatomy.names
    pace = stance.height / stance.time
    flips = {"up": {"y"}, "turning": {"x", "z"}, "velocity": {"y"}, "heading": {"yaw"}}
    scales = {
        "up": 0.5,
        "turning": ROTATION * 0.3 / stance.time,
        "velocity": 0.3 * pace,
        "heading": 0.5,
    }
    for sense in anatomy.senses:
        nothing = sense.name == "heading" and anatomy.root.is_planar
        for part in sense.order or (() if nothing else ("",)):
            name = f"{sense.name} {part}".strip()
            if sense.name in flips:
                sign = -1.0 if part in flips[sense.name] else 1.0
                centre = 1.0 if (sense.name, part) == ("up", "z") else 0.0
                if not (sense.name, part) == ("up", "z"):
                    found.append((name, place, centre, scales[sense.name], name, sign))
            elif sense.name in ("angle", "rate"):
                coordinate = anatomy.coordinates[names.index(part)]
                if names.index(part) in chosen and (sense.name == "angle" or rates):
                    other = f"{sense.name} {names[coordinate.mirror]}"
                    still = stance.qpos[names.index(part)] if sense.name == "angle" else 0.0
                    scale = 1.0 if sense.name == "angle" else RATE * 0.3 / stance.time
                    found.append((name, place, still, scale, other, coordinate.sign))
            place += 1
    return found


def _lift(anatomy: Any, tree: Any, stance: Any, coordinates: list[int]) -> tuple[float, ...]:
    """Returns how far each joint bends as its leg is lifted, in units of an action of 1."""
    from mjxwalk.envs.derived import anatomy as mjcf_anatomy

    lift = dict.fromkeys(coordinates, 0.0)
    shares = {"hip": -0.35, "knee": 0.7, "ankle": -0.35}  # rad; ours: the foot stays level
    for leg, place in zip(tree.legs, anatomy.legs, strict=True):
        signs = dict(mjcf_anatomy.bending_of(tree, stance, leg))
        for role, share in shares.items():
            coordinate = getattr(place, role)
            if coordinate in lift:
                lift[coordinate] = share * signs[coordinate - anatomy.root.num]
    return tuple(lift.values())
