"""What a controller expects and gives, in order and with units: the JSON beside an export."""

from typing import Any

import msgspec
import numpy as np

import mjxwalk
from mjxwalk import settings
from mjxwalk.controllers.controller import Network, NetworkInput
from mjxwalk.envs import Anatomy, LeggedEnv
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker

MEMORY = "memory."  # what it remembers may be called like a sense
LAWS = {  # what motors make of what controllers give, and its fields with their units
    "torque": (
        "each motor gives torque + stiffness * (target - angle) - damping * rate",
        (("torque", "N m"), ("target", "rad"), ("stiffness", "N m/rad"), ("damping", "N m s/rad")),
    ),
    "position": (
        "each motor gives torque + stiffness * (target - angle) - damping * rate",
        (("torque", "N m"), ("target", "rad"), ("stiffness", "N m/rad"), ("damping", "N m s/rad")),
    ),
    "velocity": (
        "each motor turns its joint towards the target, as fast and as strongly as it can",
        (("target", "rad"),),
    ),
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
    """
    env, controller = walker.experiment.env, walker.experiment.controller
    anatomy: Anatomy = env.anatomy
    observation = sensed(env)
    law, gives = LAWS[anatomy.motors[0].law]
    motors = tuple(motor.name for motor in anatomy.motors)
    linear = controller.describe()
    return Contract(
        mjxwalk=mjxwalk.__version__,
        walker=walker.name,
        rank=walker.rank,
        generation=walker.generation,
        experiment=walker.experiment.name,
        body=anatomy.name,
        controller=type(controller).__name__,
        settings=settings.to_data(controller),
        period_s=env.timestep,
        senses=tuple(
            _value(each.name, observation[each.name], each.unit, each.meaning, each.order)
            for each in anatomy.senses
        ),
        memory=tuple(_value(name, leaf) for name, leaf in memory_of(walker).items()),
        starts={name: np.asarray(leaf).tolist() for name, leaf in memory_of(walker).items()},
        actions=tuple(
            Value(name=name, shape=(len(motors),), dtype="float32", unit=unit, order=motors)
            for name, unit in gives
        ),
        law=law,
        roles=linear.roles,
        inputs=linear.inputs,
        networks=linear.networks,
        arrays={name: array.shape for name, array in arrays.items()},
    )


def observation_of(env: LeggedEnv) -> Any:
    """Returns what a walker senses at the start of a trial on level ground, a named tuple."""
    return env.observe(env.reset(env.level_trials().given(0)))


def sensed(env: LeggedEnv) -> dict[str, Any]:
    """Returns the fields of `observation_of` that the body has, by name."""
    fields = observation_of(env)._asdict()
    return {name: leaf for name, leaf in fields.items() if leaf is not None}


def memory_of(walker: Walker) -> dict[str, Any]:
    """Returns what the controller remembers at the start, by name, which starts with MEMORY."""
    started = flatten(walker.experiment.controller.init(walker.genotype))
    return {f"{MEMORY}{name}": leaf for name, leaf in started.items()}


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
