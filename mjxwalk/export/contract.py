"""What a controller expects and gives, in order and with units: the JSON beside an export."""

from typing import Any

import msgspec
import numpy as np

import mjxwalk
from mjxwalk import settings
from mjxwalk.controllers import LinearReactive, SpatialReactive, linear_reactive, spatial_reactive
from mjxwalk.envs import Flame, Planar7, Terrain
from mjxwalk.errors import RunError
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker
from mjxwalk.watch import bodies

MEMORY = "memory."  # what it remembers may be called like a sense
LAW = "each motor gives torque + stiffness * (target - angle) - damping * rate"
ROLES = (
    "The leg on the ground is the stance leg; of two on the ground the one whose ankle is behind; "
    "in flight the one that was. The other leg is the swing leg."
)
PLANAR_SENSES = {
    "time": ("s", "since the start of the trial; the controller blends its weights by it"),
    "pitch": ("rad", "of the upper body, forward lean positive"),
    "pitch_rate": ("rad/s", "likewise"),
    "angle": ("rad", "of each leg's joints, flexion and dorsiflexion positive"),
    "rate": ("rad/s", "of the same"),
    "contact": ("", "whether heel or toe of the left and the right foot touch the ground"),
    "ankle_x": ("m", "how far the left and the right ankle are ahead of the hip, level"),
}
SPATIAL_SENSES = {
    "time": ("s", "since the start of the trial"),
    "torso": ("rad", "yaw, pitch and roll (z-y-x): left, forward and right are positive"),
    "torso_rate": ("rad/s", "of the same angles"),
    "adduction": ("rad", "of both legs to the torso, legs apart positive"),
    "adduction_rate": ("rad/s", "likewise"),
    "angle": ("rad", "of each leg's joints, flexion, dorsiflexion and outer edge up positive"),
    "rate": ("rad/s", "of the same"),
    "contact": ("", "whether the left and the right foot touch the ground"),
    "ankle_x": ("m", "how far the left and the right ankle are ahead of the hips, as it heads"),
}


class Value(msgspec.Struct, frozen=True, kw_only=True):
    """An array that goes in or comes out.

    Attributes:
      name: of it.
      shape: [] of a number.
      dtype: "float32" or "bool".
      unit: "" where there is none.
      meaning: in a sentence.
      order: what each element is, row by row; () where the meaning says so.
    """

    name: str
    shape: tuple[int, ...]
    dtype: str
    unit: str = ""
    meaning: str = ""
    order: tuple[str, ...] = ()


class NetworkInput(msgspec.Struct, frozen=True, kw_only=True):
    """A column of the weights: (value - centre) / scale, cut to +-limit where there is one."""

    name: str
    unit: str
    centre: float
    scale: float
    limit: float | None


class Network(msgspec.Struct, frozen=True, kw_only=True):
    """A row of the weights.

    Attributes:
      name: of the angle that it drives.
      constants: that turn its output into torque, or into a target with gains, by name.
    """

    name: str
    constants: dict[str, float]


class Contract(msgspec.Struct, frozen=True, kw_only=True):
    """What there is to know of a controller to use it elsewhere.

    Attributes:
      mjxwalk: version that exported it.
      walker: source.
      rank: of the walker there.
      generation: in which it was the fittest.
      experiment: that it evolved in.
      body: class of it.
      controller: class of it.
      settings: of the controller.
      period_s: from one step of control to the next.
      senses: what goes in at each step.
      memory: what the controller remembers from one step to the next, as it starts.
      starts: the memory's values at the start.
      actions: what comes out, an element for each motor.
      law: what motors make of it.
      roles: which leg is which.
      inputs: of the networks, in the order of the weights' columns.
      networks: in the order of the weights' rows.
      arrays: shapes of the weights by name.
    """

    mjxwalk: str
    walker: str
    rank: str
    generation: int
    experiment: str
    body: str
    controller: str
    settings: dict[str, Any]
    period_s: float
    senses: tuple[Value, ...]
    memory: tuple[Value, ...]
    starts: dict[str, Any]
    actions: tuple[Value, ...]
    law: str
    roles: str
    inputs: tuple[NetworkInput, ...]
    networks: tuple[Network, ...]
    arrays: dict[str, tuple[int, ...]]


def describe(walker: Walker, arrays: dict[str, Any]) -> Contract:
    """Returns the contract of a walker's controller.

    Args:
      walker: whose controller it is.
      arrays: its weights by name.

    Raises:
      RunError: its body or controller is not known here.
    """
    env, controller = walker.experiment.env, walker.experiment.controller
    known = PLANAR_SENSES if isinstance(env, Planar7) else SPATIAL_SENSES
    observation = observation_of(env)
    motors = motor_names(env)
    gives = [("torque", "N m"), ("target", "rad"), ("stiffness", "N m/rad")]
    inputs, networks = _networks(controller)
    return Contract(
        mjxwalk=mjxwalk.__version__,
        walker=walker.name,
        rank=walker.rank,
        generation=walker.generation,
        experiment=walker.experiment.name,
        body=type(env).__name__,
        controller=type(controller).__name__,
        settings=settings.to_data(controller),
        period_s=env.timestep,
        senses=tuple(
            _value(name, leaf, *known[name], order=_order(env, name))
            for name, leaf in observation._asdict().items()
        ),
        memory=tuple(_value(name, leaf) for name, leaf in memory_of(walker).items()),
        starts={name: np.asarray(leaf).tolist() for name, leaf in memory_of(walker).items()},
        actions=tuple(
            Value(name=name, shape=(len(motors),), dtype="float32", unit=unit, order=motors)
            for name, unit in [*gives, ("damping", "N m s/rad")]
        ),
        law=LAW,
        roles=ROLES,
        inputs=inputs,
        networks=networks,
        arrays={name: array.shape for name, array in arrays.items()},
    )


def observation_of(env: Any) -> Any:
    """Returns what a walker senses at the start of a trial on level ground.

    Raises:
      RunError: the body is not known here.
    """
    if not isinstance(env, Planar7 | Flame):
        raise RunError(f"a {type(env).__name__} cannot be exported; Planar7 and Flame can")
    nodes = env.terrain.num_nodes
    level = np.zeros((1, nodes) if isinstance(nodes, int) else (1, *nodes), np.float32)
    terrain: Any = Terrain(level, np.int32(0))  # type: ignore[arg-type]
    start: Any = env.reset(terrain)
    return env.observe(start)


def memory_of(walker: Walker) -> dict[str, Any]:
    """Returns what the controller remembers at the start, by name, which starts with MEMORY."""
    started = flatten(walker.experiment.controller.init(walker.genotype))
    return {f"{MEMORY}{name}": leaf for name, leaf in started.items()}


def coordinate_names(env: Any) -> tuple[str, ...]:
    """Returns the joint of each coordinate, as in the body's XML."""
    joints: dict[int, list[str]] = {}
    for joint, coordinate in enumerate(bodies.layout(env).coordinate):
        joints.setdefault(coordinate, []).append(str(env.model.mujoco.joint(joint).name))
    # Where two legs share a coordinate, it is of neither side.
    return tuple(
        names[0] if len(names) == 1 else names[0].rpartition("_")[0] for names in joints.values()
    )


def motor_names(env: Any) -> tuple[str, ...]:
    """Returns the joint of each motor, in the order of an action."""
    names = coordinate_names(env)
    return tuple(names[motor] for motor in bodies.layout(env).motors)


def _order(env: Any, sense: str) -> tuple[str, ...]:
    names = coordinate_names(env)
    if sense in ("angle", "rate"):
        return names[3:] if isinstance(env, Planar7) else names[7:]
    if sense in ("torso", "torso_rate"):
        return ("yaw", "pitch", "roll")
    return ("left", "right") if sense in ("contact", "ankle_x") else ()


def _value(
    name: str, leaf: Any, unit: str = "", meaning: str = "", order: tuple[str, ...] = ()
) -> Value:
    return Value(
        name=name,
        shape=tuple(leaf.shape),
        dtype=str(leaf.dtype),
        unit=unit,
        meaning=meaning,
        order=order,
    )


def _networks(controller: Any) -> tuple[tuple[NetworkInput, ...], tuple[Network, ...]]:
    """Returns the inputs and networks of a linear controller, none of another."""
    if isinstance(controller, LinearReactive):
        constants = (
            {"torque_scale": np.full(6, controller.torque_scale, np.float32)}
            if controller.output == "torque"
            else {
                "target_centre": linear_reactive.TARGET_CENTRE,
                "target_scale": linear_reactive.TARGET_SCALE,
                "stiffness": linear_reactive.STIFFNESS,
                "damping": linear_reactive.DAMPING,
            }
        )
        return _inputs(linear_reactive, None), _rows(linear_reactive.NETWORKS, constants)
    if isinstance(controller, SpatialReactive):
        constants = {
            "target_scale": spatial_reactive.TARGET_SCALE,
            "target_lowest": spatial_reactive.TARGET_LOWEST,
            "target_highest": spatial_reactive.TARGET_HIGHEST,
            "stiffness": spatial_reactive.STIFFNESS,
            "damping": spatial_reactive.DAMPING,
        }
        limit = spatial_reactive.LARGEST_INPUT
        return _inputs(spatial_reactive, limit), _rows(spatial_reactive.NETWORKS, constants)
    return (), ()


def _inputs(source: Any, limit: float | None) -> tuple[NetworkInput, ...]:
    """Returns the inputs of a module with angles, their rates, double stance and a bias."""
    angles = zip(source.ANGLES, source.ANGLE_CENTRE, source.ANGLE_SCALE, strict=True)
    rates = zip(source.ANGLES, source.RATE_SCALE, strict=True)
    flat = [
        *((name, "rad", centre, scale, limit) for name, centre, scale in angles),
        *((f"{name} rate", "rad/s", 0.0, scale, limit) for name, scale in rates),
        ("double stance", "", 0.0, 1.0, None),
        ("bias", "", 0.0, 1.0, None),
    ]
    return tuple(
        NetworkInput(name=name, unit=unit, centre=float(centre), scale=float(scale), limit=most)
        for name, unit, centre, scale, most in flat
    )


def _rows(names: tuple[str, ...], constants: dict[str, Any]) -> tuple[Network, ...]:
    return tuple(
        Network(name=name, constants={key: float(values[row]) for key, values in constants.items()})
        for row, name in enumerate(names)
    )
