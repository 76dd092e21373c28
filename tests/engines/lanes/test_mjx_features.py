"""What docs/mjx-features.md says of MJX's features in lanes."""

from pathlib import Path

import pytest
from engines.lanes.mjx_comparison import difference, stepping
from engines.lanes.mjx_features import FEATURES, NUM_STATES, Feature, states

from mjxwalk.envs._mujoco import mujoco

PAGE = Path(__file__).parents[3] / "docs" / "mjx-features.md"
AGREES, REFUSED_BY_MJX, NOT_KNOWN = "agrees", "MJX refuses", "not known"

# Of the largest number of its kind, in float64: solvers stop by tolerances of their own, and what
# they do not resolve is decided by rounding.
TOLERANCE = 1e-9


def rows() -> dict[str, str]:
    """Returns what the page's tables say of each feature."""
    found: dict[str, str] = {}
    heading = ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            heading = line[3:]
        if line.startswith("| ") and not line.startswith(("| ---", "| feature")):
            names, what = (cell.strip() for cell in line.strip("|").split("|"))
            found[f"{heading}: {names}"] = what
    return found


def title(feature: Feature) -> str:
    """Returns where the page has a feature."""
    return f"{feature.group}: {', '.join(feature.names)}"


COMPARED = [feature for feature in FEATURES if rows().get(title(feature)) == AGREES]
REFUSED = [feature for feature in FEATURES if feature.refused]


def test_the_page_has_these_features_and_no_others() -> None:
    said = rows()
    assert set(said) == set(map(title, FEATURES))
    for feature in FEATURES:
        possible = [REFUSED_BY_MJX] if feature.refused else [AGREES, NOT_KNOWN]
        assert said[title(feature)] in possible


@pytest.mark.parametrize("feature", REFUSED, ids=title)
def test_mjx_refuses_what_the_page_says_it_does(feature: Feature) -> None:
    built = mujoco.MjModel.from_xml_string(feature.model)
    with pytest.raises(NotImplementedError, match=feature.refused):
        stepping(built)


@pytest.mark.parametrize("feature", [f for f in FEATURES if " and " in title(f)], ids=title)
def test_what_is_to_touch_touches_in_some_states(feature: Feature) -> None:
    built = mujoco.MjModel.from_xml_string(feature.model)
    data, touching = mujoco.MjData(built), 0
    for qpos, *_ in zip(*states(built, feature.height), strict=True):
        data.qpos[:] = qpos
        mujoco.mj_forward(built, data)
        touching += data.ncon > 0
    assert touching >= NUM_STATES / 3


@pytest.mark.slow
@pytest.mark.parametrize("feature", COMPARED, ids=title)
def test_a_step_in_lanes_is_that_of_mjx(feature: Feature) -> None:
    assert difference(feature) <= TOLERANCE
