"""Which inputs each network sees: tables of links by name, shared by the linear controllers."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from mjxwalk.controllers.controller import Network, NetworkInput
from mjxwalk.errors import near

# Which leg is which to networks that belong to roles.
ROLES = (
    "The leg on the ground is the stance leg; of two on the ground the one whose ankle is behind; "
    "in flight the one that was. The other leg is the swing leg."
)
Links = str | Mapping[str, tuple[str, ...]]


def check(links: Links, networks: Sequence[str], inputs: Sequence[str]) -> None:
    """Returns if the links are "local", "all" or a table of known names.

    Raises:
      ValueError: they are not.
    """
    if not isinstance(links, Mapping):
        if links not in ("local", "all"):
            raise ValueError(
                "links must be local, all or a table of inputs by network, such as "
                f'{{"torso": ["inter-leg"]}}, got {links!r}'
            )
        return
    for network, names in links.items():
        if network not in networks:
            raise ValueError(f"links has no network {network!r}{near(network, networks)}")
        for name in names:
            if name not in inputs:
                raise ValueError(f"links of {network} has no input {name!r}{near(name, inputs)}")


def mask(
    links: Links, networks: Sequence[str], inputs: Sequence[str]
) -> Bool[np.ndarray, "network input"]:
    """Returns which network sees which input; its own angle, own rate and a bias it always does."""
    if links == "all":
        return np.ones((len(networks), len(inputs)), bool)
    there = np.zeros((len(networks), len(inputs)), bool)
    table: Mapping[str, tuple[str, ...]] = links if isinstance(links, Mapping) else {}
    for row, network in enumerate(networks):
        for name in (network, f"{network} rate", "bias", *table.get(network, ())):
            there[row, inputs.index(name)] = True
    return there


def numbered(free: Bool[np.ndarray, "network input"]) -> Int[np.ndarray, "network input"]:
    """Returns a number of its own for each that is free, -1 for the others."""
    numbers = np.full(free.shape, -1, np.int32)
    numbers[free] = np.arange(np.count_nonzero(free))
    return numbers


def rows(
    weight_set: str,
    values: Float[np.ndarray, "network input"],
    present: Bool[np.ndarray, "network input"],
    networks: Sequence[str],
    inputs: Sequence[str],
) -> list[tuple[str, str, str, float]]:
    """Returns weights as rows of weight set, network, input and value; those present only."""
    return [
        (weight_set, networks[int(i)], inputs[int(j)], float(values[i, j]))
        for i, j in np.argwhere(present)
    ]


def described_inputs(
    angles: Sequence[str],
    centre: Float[np.ndarray, " angle"],
    scale: Float[np.ndarray, " angle"],
    rate_scale: Float[np.ndarray, " angle"],
    limit: float | None = None,
) -> tuple[NetworkInput, ...]:
    """Returns networks' inputs: angles, their rates, double stance and a bias.

    Args:
      angles: their names.
      centre: of the angles, rad.
      scale: of the angles, rad.
      rate_scale: of their rates, rad/s.
      limit: at which scaled angles and rates are cut; None for none.
    """
    flat = [
        *((name, "rad", c, s, limit) for name, c, s in zip(angles, centre, scale, strict=True)),
        *(
            (f"{name} rate", "rad/s", 0.0, s, limit)
            for name, s in zip(angles, rate_scale, strict=True)
        ),
        ("double stance", "", 0.0, 1.0, None),
        ("bias", "", 0.0, 1.0, None),
    ]
    return tuple(
        NetworkInput(name=name, unit=unit, centre=float(c), scale=float(s), limit=most)
        for name, unit, c, s, most in flat
    )


def described_networks(
    names: Sequence[str], constants: Mapping[str, Float[np.ndarray, " network"]]
) -> tuple[Network, ...]:
    """Returns networks, each with its own of the constants."""
    return tuple(
        Network(name=name, constants={key: float(values[row]) for key, values in constants.items()})
        for row, name in enumerate(names)
    )
