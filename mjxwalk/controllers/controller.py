"""What a controller is: a template of weights, and a pure function from senses to an action."""

import abc
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import msgspec
import numpy as np


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


class Description(NamedTuple):
    """What there is to know of a controller beside its memory and its weights' shapes.

    Attributes:
      inputs: of its networks, in the order of the weights' columns; () of other kinds.
      networks: in the order of the weights' rows; () of other kinds.
      roles: which leg is which, where the weights belong to roles; else "".
    """

    inputs: tuple[NetworkInput, ...] = ()
    networks: tuple[Network, ...] = ()
    roles: str = ""


class Controller(abc.ABC):
    """Turns a genotype into a walker's behaviour; settings are a frozen dataclass.

    A controller has to say what its weights are and what it does; all else has a default. All
    methods are pure, and written for one walker.
    """

    @abc.abstractmethod
    def template(self) -> Any:
        """Returns the genotype that generation 0 is drawn around: a pytree of arrays."""

    @abc.abstractmethod
    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, Any]:
        """Returns the new memory and the motors' action."""

    def on(self, env: Any) -> "Controller":
        """Returns the controller for an environment, told what it has to know of the body."""
        del env
        return self

    def init(self, genotype: Any, /) -> Any:
        """Returns the memory at the start of a trial, a pytree; nothing is remembered."""
        del genotype
        return ()

    def mask(self) -> Any:
        """Returns which weights are there, in the shape of a genotype: all are."""
        return jax.tree.map(lambda leaf: jnp.ones(jnp.shape(leaf), bool), self.template())

    def prunable(self) -> Any:
        """Returns the number of the link that each weight belongs to, -1 where it must stay.

        None may go.
        """
        return jax.tree.map(lambda leaf: jnp.full(jnp.shape(leaf), -1), self.template())

    def networks(self) -> Any:
        """Returns the number of the network that each weight belongs to: all are of one.

        Weights of a network share mutation rates, and cross over together.
        """
        return jax.tree.map(lambda leaf: jnp.zeros(jnp.shape(leaf), int), self.template())

    def steps_held(self) -> int:
        """Returns for how many steps of the physics an action is asked for: one."""
        return 1

    def steps_per_action(self) -> int:
        """Returns for how many steps of the physics an action stays the same."""
        return self.steps_held()

    def held(self, memory: Any, /) -> Any:
        """Returns the memory after `act` and the steps for which that action was asked for."""
        return memory

    def nothing_known(self) -> Any:
        """Returns what is known of the senses at first, as part of genotypes.

        None of a controller that does not normalise its senses; see `controllers.normalisation`.
        """
        return None

    def sensed(self, memory: Any, /) -> Any:
        """Returns what was sensed in a trial, by its memory at the end; None as above."""
        del memory
        return None

    def weight_table(self, genotype: Any) -> list[tuple[str, str, str, float]]:
        """Returns a genotype as rows of weight set, network, input and value.

        They are the leaves by name and the places in them.
        """
        return [
            (
                "weights",
                jax.tree_util.keystr(path).strip("."),
                " ".join(map(str, place)),
                float(one),
            )
            for path, leaf in jax.tree.leaves_with_path(genotype)
            for place, one in np.ndenumerate(np.asarray(leaf))
        ]

    def describe(self) -> Description:
        """Returns what exports tell of it."""
        return Description()

    def scaled(self, by: float) -> "Controller":
        """Returns the controller for a body whose torques are so many times as large."""
        del by
        return self


def missing(controller: Any) -> list[str]:
    """Returns what an object lacks to be a controller, () if nothing."""
    names = [name for name in vars(Controller) if not name.startswith("_")]
    return [name for name in names if not callable(getattr(controller, name, None))]
