"""Tests of the study of Reil & Massey: its phases, how a population goes on, and its fitness."""

import dataclasses
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from trial_states import counted

from mjxwalk import experiments
from mjxwalk.controllers import Controller
from mjxwalk.controllers.ctrnn_walker import CtrnnWalker
from mjxwalk.envs import HipTargets, Reil, State, Trial
from mjxwalk.envs.bodies.reil_trials import usual
from mjxwalk.experiments import run_config
from mjxwalk.rollout import rollout
from mjxwalk.runs import config
from mjxwalk.runs.trees import flatten
from mjxwalk.tournament import conditions

UNASSISTED = experiments.get("reil-unassisted")
STUDY = experiments.get_study("reil")


def test_assistance_is_a_phase_and_ends_at_the_milestone() -> None:
    assisted, unassisted, _ = (experiment for _, experiment in STUDY.phases)
    assert assisted.env.assistance > 0.0 and unassisted.env.assistance == 0.0
    assert assisted.start == "zero" and unassisted.start == "population"
    assert assisted.goal.distance == unassisted.goal.distance == assisted.env.max_distance == 20.0
    without = {f.name: f.default for f in dataclasses.fields(Reil) if "assistance" in f.name}
    body = dataclasses.replace(assisted.env, **without)
    assert body == unassisted.env and body.terrain.is_usual()


def test_a_steady_walker_has_to_hold_where_trials_differ_and_at_half_the_step() -> None:
    steady = STUDY.phase("steady")
    assert not steady.env.terrain.is_usual() and steady.terrains_per_evaluation > 1
    assert steady.goal.is_fine and steady.goal.fine_factor == 2
    trials = steady.sample_trials(jax.random.key(0), 50, steady.first_roughness())
    slope = trials.heights / steady.env.terrain.slope
    drawn = np.concatenate([trials.start, trials.load[:, None], slope], axis=1)
    assert len(np.unique(drawn)) == drawn.size == 50 * 6 and np.abs(drawn).max() <= 1.0


def test_evolution_is_the_papers() -> None:
    for _, experiment in STUDY.phases[:2]:
        assert experiment.strategy.name == "truncation-ga"
        assert experiment.population_size == 100
        assert isinstance(experiment.controller, CtrnnWalker) and experiment.controller.sense == 0


def test_genes_start_between_their_bounds_and_senses_that_are_not_there_stay_zero() -> None:
    strategy = UNASSISTED.make_strategy()
    state = strategy.init(jax.random.key(0), UNASSISTED.template())
    population, _ = strategy.ask(jax.random.key(1), state)
    np.testing.assert_array_equal(population.sense, 0.0)
    genes = np.concatenate([np.asarray(leaf).ravel() for leaf in population[:5]])
    assert genes.size == 100 * 60 and np.abs(genes).max() <= 1.0
    # Uniform: of 6,000 numbers the mean is within 0.03 but for one case in a thousand.
    assert abs(genes.mean()) < 0.03 and abs(genes.var() - 1.0 / 3.0) < 0.03


def test_a_population_goes_on_without_assistance_as_it_was() -> None:
    assisted, unassisted, _ = (experiment for _, experiment in STUDY.phases)
    strategy = assisted.make_strategy()
    state = strategy.init(jax.random.key(0), assisted.template())
    population, state = strategy.ask(jax.random.key(1), state)
    fitness = jnp.arange(100.0)
    state, _ = strategy.tell(jax.random.key(2), population, fitness, state)
    before = {n.removeprefix("inner."): a for n, a in flatten(state).items() if "inner." in n}
    strategy = unassisted.make_strategy()
    fresh = strategy.init(jax.random.key(3), unassisted.template())
    taken = unassisted.take_over(strategy, fresh, before, np.zeros(1))
    theirs, _ = jax.jit(strategy.ask)(jax.random.key(4), taken)
    # The better half, best first, is as it was; the other half are its mutated copies.
    for leaf, old in zip(jax.tree.leaves(theirs), jax.tree.leaves(population), strict=True):
        np.testing.assert_array_equal(leaf[:50], old[99:49:-1])
    changed = sum(
        int((np.asarray(leaf[50:]) != np.asarray(leaf[:50])).sum()) for leaf in theirs[:5]
    )
    assert 25 <= changed <= 80  # one of sixty on average: 50 of 3,000, give or take 7


def test_settings_read_back_from_a_runs_file(tmp_path: Path) -> None:
    for name in ("reil/assisted", "reil/steady", "reil-feedback/feedback"):
        experiment = experiments.get(name)
        config.write(tmp_path, run_config.to_file(run_config.Config(experiment=experiment)))
        assert run_config.read(tmp_path).experiment == experiment


class Still(Controller):
    """Asks the hips to stay where they are."""

    def template(self) -> Any:
        """Returns an angle for each hip."""
        return jnp.zeros(2)

    def act(self, genotype: Any, memory: Any, observation: Any, /) -> tuple[Any, HipTargets]:
        """Returns the genotype as targets."""
        del observation
        return memory, HipTargets(genotype)


def test_fitness_is_the_hindmost_foots_distance_and_zero_of_a_fall_on_the_spot() -> None:
    class Fallen(Reil):
        """A body that is where it falls at once."""

        def step(self, state: State, action: HipTargets, given: Trial) -> State:
            """Returns the end of the trial."""
            del given
            ended = counted(state, fell=jnp.ones((), bool), done=jnp.ones((), bool))
            return ended._replace(
                qpos=state.qpos.at[0].set(action.target[0]), ankle_x=jnp.array([0.4, -0.3])
            )

    trial = usual().given(jnp.zeros((), jnp.int32))
    far, near = (rollout(Fallen(), Still(), jnp.array([x, 0.0]), trial) for x in (5.0, 0.5))
    np.testing.assert_allclose([far.fitness, far.distance], [4.7, 5.0], rtol=1e-6)
    np.testing.assert_allclose([near.fitness, near.distance], [0.0, 0.5], rtol=1e-6)


def test_tournaments_try_half_the_step_and_other_starts() -> None:
    key = jax.random.key(0)
    trials = UNASSISTED.sample_trials(key, 4, UNASSISTED.first_roughness())
    found = {setting.name: setting for setting in conditions.settings(UNASSISTED, trials, key)}
    assert len(found) == 3
    half, starts = (
        found[name].experiment.env for name in (conditions.HALF_STEP, conditions.PERTURBED)
    )
    assert half.timestep == UNASSISTED.env.timestep / 2
    perturbed = found[conditions.PERTURBED].trials
    reset = jax.jit(lambda row: starts.reset(perturbed.given(row)))
    pushes = [float(reset(jnp.int32(row)).qvel[0]) for row in range(4)]
    assert len(set(pushes)) == 4 and max(map(abs, pushes)) <= starts.terrain.push
