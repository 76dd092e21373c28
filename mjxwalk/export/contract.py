"""What a controller expects and gives, in order and with units: the JSON beside an export."""

from typing import Any

import msgspec
import numpy as np

import mjxwalk
from mjxwalk import settings
from mjxwalk.controllers.controller import Network, NetworkInput
from mjxwalk.controllers.normalisation import Normalised, divisors
from mjxwalk.envs import Anatomy, LeggedEnv
from mjxwalk.export import step
from mjxwalk.walker import Walker

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

TASK_LAW = "numbers are cut to -1 ... 1; the task scales them to the range of its controls"


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
      body: its name, or that of the task.
      controller: class of it.
      settings: of the controller.
      period_s: from one step of control to the next.
      senses: what goes in at each step.
      memory: what the controller remembers from one step to the next, as it starts.
      starts: the memory's values at the start.
      actions: what comes out, an element for each motor.
      law: what motors make of it.
      roles: which leg is which.
      inputs: of the networks, in the order of the weights' columns; of normalised senses centre and
        scale are mean and standard deviation.
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
    made, linear = step.of(walker), controller.describe()
    senses, actions, law = _of_task(env) if step.is_task(env) else _of_body(env, made.senses)
    return Contract(
        mjxwalk=mjxwalk.__version__,
        walker=walker.name,
        rank=walker.rank,
        generation=walker.generation,
        experiment=walker.experiment.name,
        body=type(env).__name__ if step.is_task(env) else env.anatomy.name,
        controller=type(controller).__name__,
        settings=settings.to_data(controller),
        period_s=env.timestep,
        senses=senses,
        memory=tuple(_value(name, leaf) for name, leaf in made.memory.items()),
        starts={name: np.asarray(leaf).tolist() for name, leaf in made.memory.items()},
        actions=actions,
        law=law,
        roles=linear.roles,
        inputs=_as_normalised(linear.inputs, walker),
        networks=linear.networks,
        arrays={name: array.shape for name, array in arrays.items()},
    )


def _of_body(
    env: LeggedEnv, senses: dict[str, Any]
) -> tuple[tuple[Value, ...], tuple[Value, ...], str]:
    """Returns what a body senses, what its motors take, and what they make of it."""
    anatomy: Anatomy = env.anatomy
    law, gives = LAWS[anatomy.motors[0].law]
    motors = tuple(motor.name for motor in anatomy.motors)
    sensed = tuple(
        _value(each.name, senses[each.name], each.unit, each.meaning, each.order)
        for each in anatomy.senses
    )
    actions = tuple(
        Value(name=name, shape=(len(motors),), dtype="float32", unit=unit, order=motors)
        for name, unit in gives
    )
    return sensed, actions, law


def _of_task(env: Any) -> tuple[tuple[Value, ...], tuple[Value, ...], str]:
    """Returns what a task without a body gives, what it takes, and what it makes of that."""
    observed, moved = tuple(env.observation_names), tuple(env.action_names)
    observation, action = (
        Value(name=name, shape=(len(order),), dtype="float32", order=order)
        for name, order in ((step.OBSERVATION, observed), (step.ACTION, moved))
    )
    return (observation,), (action,), TASK_LAW


def _as_normalised(inputs: tuple[NetworkInput, ...], walker: Walker) -> tuple[NetworkInput, ...]:
    """Returns inputs whose centres and scales are mean and standard deviation of what was sensed.

    Both in the unit of the sense; inputs of a walker that does not normalise its senses stay.
    """
    if not isinstance(walker.genotype, Normalised):
        return inputs
    senses, limit = walker.genotype.senses, walker.experiment.controller.limit
    deviation = np.asarray(divisors(senses))
    normalised = [
        msgspec.structs.replace(
            each,
            centre=each.centre + each.scale * float(senses.mean[place]),
            scale=each.scale * float(deviation[place]),
            limit=limit,
        )
        for place, each in enumerate(inputs[: len(deviation)])
    ]
    return (*normalised, *inputs[len(deviation) :])  # the clock is none of the senses


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
