"""A walker's controller as a file for other programs: its weights, or all of it as ONNX."""

import json
from typing import Any

import jax
import msgspec
import numpy as np

from mjxwalk import installing
from mjxwalk.engines.pinning import pinned
from mjxwalk.export import contract, tracing
from mjxwalk.outputs import as_json
from mjxwalk.runs.result import npz
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker

NEXT = "next."  # in place of MEMORY, of what ONNX gives back to be remembered


def weights(walker: Walker) -> dict[str, Any]:
    """Returns a walker's weights by name; those that are no links are zero."""
    arrays = flatten(walker.genotype)
    present = flatten(walker.experiment.controller.mask())
    return {
        name: np.where(present[name], array, np.zeros((), array.dtype))
        for name, array in arrays.items()
    }


def told(walker: Walker) -> bytes:
    """Returns the JSON beside an export.

    Raises:
      RunError: the body or the controller is not known here.
    """
    return as_json(contract.describe(walker, weights(walker)))


def as_npz(walker: Walker) -> bytes:
    """Returns the weights as npz."""
    return npz(weights(walker))


def as_safetensors(walker: Walker) -> bytes:
    """Returns the weights as safetensors, with the contract as JSON in their metadata.

    Raises:
      RunError: safetensors is not installed.
    """
    library = installing.load("safetensors.numpy", "export", "--to safetensors")
    described = msgspec.to_builtins(contract.describe(walker, weights(walker)))
    arrays = {name: np.ascontiguousarray(array) for name, array in weights(walker).items()}
    return library.save(arrays, metadata={"contract": json.dumps(described, sort_keys=True)})


@pinned()
def as_onnx(walker: Walker) -> bytes:
    """Returns a step of control as ONNX, sensing of roles and memory included.

    Inputs are the senses and the memory by name, outputs the action by name, as the motors take it,
    and the memory of the next step, `next.NAME` of `memory.NAME`.

    Raises:
      RunError: onnx is not installed, or it has no such operation.
    """
    env, controller = walker.experiment.env, walker.experiment.controller
    observation, sensed = contract.observation_of(env), contract.sensed(env)
    start = controller.init(walker.genotype)
    tree = jax.tree.structure(start)
    memories = contract.memory_of(walker)

    def step(**values: Any) -> dict[str, Any]:
        seen = observation._replace(**{name: values[name] for name in sensed})
        memory = jax.tree.unflatten(tree, [values[name] for name in memories])
        after, action = controller.act(walker.genotype, memory, seen)
        plain = not isinstance(action, tuple)  # numbers from -1 to 1
        asked: Any = env.scaled_action(action) if plain else action
        remembered = (f"{NEXT}{name.removeprefix(contract.MEMORY)}" for name in memories)
        return asked._asdict() | dict(zip(remembered, jax.tree.leaves(after), strict=True))

    senses = {**sensed, **memories}
    like = {name: jax.ShapeDtypeStruct(leaf.shape, leaf.dtype) for name, leaf in senses.items()}
    return tracing.to_onnx(step, like)
