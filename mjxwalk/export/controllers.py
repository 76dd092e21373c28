"""A walker's controller as a file for other programs: its weights, or all of it as ONNX."""

import json
from typing import Any

import jax
import msgspec
import numpy as np

from mjxwalk import installing
from mjxwalk.controllers.normalisation import Normalised
from mjxwalk.engines.pinning import pinned
from mjxwalk.export import contract, step, tracing
from mjxwalk.outputs import as_json
from mjxwalk.runs.result import npz
from mjxwalk.runs.trees import flatten
from mjxwalk.walker import Walker


def weights(walker: Walker) -> dict[str, Any]:
    """Returns a walker's weights, and what it knows of its senses, by name.

    Weights that are no links are zero.
    """
    arrays = flatten(walker.genotype)
    mask = walker.experiment.controller.mask()
    if isinstance(mask, Normalised):  # strategies leave alone what is known of the senses
        mask = mask._replace(senses=jax.tree.map(np.ones_like, mask.senses))
    present = flatten(mask)
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
    arrays = {name: np.asarray(array, order="C") for name, array in weights(walker).items()}
    return library.save(arrays, metadata={"contract": json.dumps(described, sort_keys=True)})


@pinned()
def as_onnx(walker: Walker) -> bytes:
    """Returns a step of control, see `Step.run`, as ONNX, sensing of roles and memory included.

    Raises:
      RunError: onnx is not installed, or it has no such operation.
    """
    made = step.of(walker)
    return tracing.to_onnx(made.run, step.shapes(made.senses | made.memory))
