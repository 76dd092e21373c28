"""The report's section on networks that have lost links."""

import dataclasses
from typing import Any

import numpy as np
from report.made import phase

from mjxwalk import experiments
from mjxwalk.experiments.rewiring import Rewiring
from mjxwalk.report import networks
from mjxwalk.report.parts import Picture, Table
from mjxwalk.runs.trees import flatten, unflatten

WALK: Any = experiments.get("walk+ctrnn")


def thinned(seed: int = 0, share: float = 0.2, **changes: Any) -> Any:
    """Returns a made-up run whose network has a share of its links left."""
    experiment = dataclasses.replace(WALK, rewiring=Rewiring(), **changes)
    policy, draws = experiment.controller, np.random.default_rng(seed)
    there, numbers = flatten(policy.mask()), flatten(policy.prunable())
    weights = {
        name: there[name]
        * np.where(
            (numbers[name] < 0) | (draws.uniform(size=there[name].shape) < share),
            draws.normal(size=there[name].shape),
            0.0,
        )
        for name in there
    }
    genotype = unflatten(
        policy.template(), {n: np.asarray(w, np.float32) for n, w in weights.items()}
    )
    return phase("walk", study="", seed=seed, experiment=experiment, genotype=genotype)


def parts(*phases: Any) -> tuple[Table, Picture]:
    section = networks.section({"walk": phases})
    assert section is not None
    table, picture = section.parts
    assert isinstance(table, Table) and isinstance(picture, Picture)
    return table, picture


def test_links_are_counted_between_each_two_layers() -> None:
    run = thinned()
    table, picture = parts(run)
    rows = {row.head: [cell.text for cell in row.cells] for row in table.groups[0].rows}
    weights = flatten(run.walker.genotype)
    left = np.count_nonzero(weights["weights"])
    assert rows["neurons to neurons"][:3] == ["36", str(left), f"{100 * left / 36:.1f} %"]
    unread = int((weights["motors"] == 0).all(axis=0).sum())
    assert rows["neurons to motors"][4] == str(unread)
    drawn = picture.data
    assert drawn is not None and len(drawn) == sum(table.data["left"])
    one = drawn[(drawn["from"] == "neuron 2") & (drawn["to_layer"] == "motors")]
    np.testing.assert_allclose(
        sorted(one["weight"]), sorted(v for v in weights["motors"][:, 1] if v), rtol=1e-6
    )
    assert picture.svg.count("<path") > len(drawn)


def test_of_several_runs_means_and_ranges_are_told_and_the_best_is_drawn() -> None:
    worse, best = thinned(0), dataclasses.replace(thinned(1, share=0.5), name="walk")
    best = dataclasses.replace(
        best, run=dataclasses.replace(best.run, metrics={"best_fitness": np.array([9.0])})
    )
    table, picture = parts(worse, best)
    counts = [np.count_nonzero(flatten(run.walker.genotype)["weights"]) for run in (worse, best)]
    cells = {row.head: row.cells for row in table.groups[0].rows}["neurons to neurons"]
    assert cells[1].text == f"{np.mean(counts):.0f} ({min(counts)} to {max(counts)})"
    assert best.label in picture.caption
    assert table.data["seed"].tolist() == [0, 1] * 4


def test_sparse_ones_have_a_section_and_whole_ones_none() -> None:
    whole = phase("walk", study="", experiment=WALK, genotype=WALK.controller.template())
    assert networks.section({"walk": [whole]}) is None
    sparse = dataclasses.replace(WALK.controller, density=0.5)
    experiment = dataclasses.replace(WALK, controller=sparse)
    thin = phase("walk", study="", experiment=experiment, genotype=sparse.template())
    assert networks.section({"walk": [thin]}) is not None
    assert networks.section({"fil": [phase("fil")]}) is None
