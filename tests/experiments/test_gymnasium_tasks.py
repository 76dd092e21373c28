"""Tests of Gymnasium's tasks as experiments."""

from typing import Any

import pytest

from mjxwalk import experiments, settings
from mjxwalk.envs.gymnasium import TASKS, files
from mjxwalk.envs.gymnasium.healthy import HealthyTask

gymnasium = pytest.importorskip("gymnasium")


def test_every_task_is_an_experiment_by_its_name() -> None:
    named = [name for name in experiments.names() if name.startswith("gymnasium/")]
    assert named == [f"gymnasium/{task}" for task in TASKS]


@pytest.mark.parametrize("task", TASKS)
def test_walkers_evolve_without_the_bonus_that_they_are_tested_with(task: str) -> None:
    experiment = experiments.get(f"gymnasium/{task}")
    assert isinstance(experiment.env, TASKS[task])
    tested = experiment.as_tested().env
    assert tested == TASKS[task]()
    if isinstance(tested, HealthyTask):
        env: Any = experiment.env
        assert env.healthy_reward == 0.0 < tested.healthy_reward
    assert experiment.controller.layout.inputs == tested.observation_names
    assert experiment.controller.layout.outputs == tested.action_names


@pytest.mark.parametrize("task", TASKS)
def test_policies_begin_with_the_noise_of_the_published_search(task: str) -> None:
    published = {  # in units of the environment's actions
        "Walker2d-v5": 0.025,
        "Hopper-v5": 0.025,
        "HalfCheetah-v5": 0.03,
        "Ant-v5": 0.025,
        "Humanoid-v5": 0.0075,
    }
    environment = gymnasium.make(task)
    largest = float(environment.action_space.high[0])  # type: ignore[attr-defined]
    environment.close()
    options = experiments.get(f"gymnasium/{task}").strategy.options
    assert options["sigma"] * largest == pytest.approx(published[task])


def test_a_run_is_read_where_gymnasium_is_missing(monkeypatch: Any) -> None:
    for name in ("gymnasium/Hopper-v5", "gymnasium/Hopper-v5+mlp"):
        made = settings.override(experiments.get(name), "env.integrator", "euler")
        with monkeypatch.context() as patch:
            patch.setattr(files.importlib.util, "find_spec", lambda _: None)
            files.text.cache_clear()
            assert experiments.from_data(settings.to_data(made)) == made
            with pytest.raises(ValueError, match=r"takes its body from gymnasium.*install"):
                experiments.get(name)
        files.text.cache_clear()
