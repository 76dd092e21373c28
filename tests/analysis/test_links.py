"""Tests of counting links over runs."""

from typing import Any

import numpy as np

from mjxwalk.analysis import links, paper
from mjxwalk.controllers import LinearReactive, Weights
from mjxwalk.controllers.linear_reactive import INPUTS, NETWORKS, local_links

LOCAL = local_links()


def genotype(*present: tuple[str, str]) -> Any:
    """Returns weights of the local links and of those named, network and input."""
    mask = LOCAL.copy()
    for network, name in present:
        mask[NETWORKS.index(network), INPUTS.index(name)] = True
    weights = mask.astype(np.float32)
    return Weights(weights, -2.0 * weights, np.float32(0.5), None)  # type: ignore[arg-type]


HALF, FULL = ("torso", "inter-leg"), ("stance ankle", "torso rate")
FIVE = [genotype(HALF, FULL), genotype(FULL), genotype(HALF, FULL), genotype(FULL), genotype()]


def test_links_are_the_weights_that_are_not_zero() -> None:
    present = links.presence(FIVE)
    assert present.shape == (5, 6, 16)
    np.testing.assert_array_equal(present[4], LOCAL)
    assert present[0].sum() == LOCAL.sum() + 2


def test_a_link_in_one_weight_set_alone_is_there() -> None:
    only = genotype(HALF)
    only = only._replace(walking=only.walking * LOCAL)
    assert links.presence([only])[0].sum() == LOCAL.sum() + 1


def test_table_counts_runs_by_input_and_network() -> None:
    table = links.survival_table(links.presence(FIVE))
    assert table.loc["inter-leg", "torso"] == 2
    assert table.loc["torso rate", "stance ankle"] == 4
    assert table.loc["bias", "swing knee"] == 5  # local links are never removed
    assert table.to_numpy().sum() == 5 * LOCAL.sum() + 2 + 4


def test_retention_is_of_the_thirteen_non_local_links() -> None:
    kept = links.retention(links.presence(FIVE))
    assert np.all((~LOCAL).sum(axis=1) == 13)
    np.testing.assert_allclose(kept, [2 / (5 * 13), 0, 0, 0, 4 / (5 * 13), 0])


def test_four_of_five_runs_are_enough_for_the_reduced_set() -> None:
    reduced = links.reduced(links.presence(FIVE))
    assert links.as_setting(reduced) == {"stance ankle": ("torso rate",)}
    assert links.as_setting(links.reduced(links.presence(FIVE), threshold=0.81)) == {}
    assert links.reduced(links.presence(FIVE), threshold=0.81).sum() == LOCAL.sum()


def test_the_reduced_set_is_a_controllers_links() -> None:
    reduced = links.reduced(links.presence(FIVE), threshold=0.3)
    controller = LinearReactive(links=links.as_setting(reduced))
    np.testing.assert_array_equal(controller.mask().walking, reduced)


def test_the_papers_percentages_leave_thirty_links() -> None:
    # Sections 2.7.5 and 3.2: 18 local links and 15 others make up the reduced set.
    np.testing.assert_allclose(13 * sum(paper.RETENTION.values()), 30.7, atol=0.05)
    assert sum(paper.REDUCED.values()) + LOCAL.sum() == 33
