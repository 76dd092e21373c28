"""Tests of settings that older versions of mjxwalk wrote."""

import shutil
from pathlib import Path

from mjxwalk.experiments import run_config

# The `config.json` of a run of solomon-2d/lpd, from before `arena` was called `test_settings`.
BEFORE_RENAMING = Path(__file__).parent / "config_before_renaming.json"


def test_a_setting_that_was_renamed_is_read_by_its_old_name(tmp_path: Path) -> None:
    assert '"arena"' in BEFORE_RENAMING.read_text(encoding="utf-8")
    shutil.copy(BEFORE_RENAMING, tmp_path / "config.json")
    settings = run_config.read(tmp_path)
    assert settings.experiment.test_settings == {"terrain.roughness": 0.02, "torque_budget": 3000.0}
    assert settings.experiment.as_tested().env.terrain.roughness == 0.02
    assert b'"test_settings"' in run_config.text(settings)


def test_runs_from_before_pushes_and_payloads_have_none(tmp_path: Path) -> None:
    shutil.copy(BEFORE_RENAMING, tmp_path / "config.json")
    env = run_config.read(tmp_path).experiment.env
    assert not env.push and not env.payload and not env.course.num_channels
