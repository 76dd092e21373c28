"""Tries a user's task before it evolves: what is wrong is told with file and line, in seconds.

Every function of the task is traced for one walker, and one walker's trial is run to its end.
"""

import inspect
import re
from collections.abc import Callable
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from mjxwalk.engines.pinning import pinned
from mjxwalk.envs import Trials, TrialState
from mjxwalk.errors import RunError
from mjxwalk.experiments.experiment import Experiment
from mjxwalk.experiments.own_task import blame, shapes, side_effects
from mjxwalk.experiments.own_task.execution import MODULE, Task
from mjxwalk.experiments.own_task.first_trial import FirstTrial
from mjxwalk.rollout import Outcome

NUM_TRIALS = 2
MOST_WALKERS = 8  # that are tried until one has a fitness; ours


@pinned()
def check(task: Task, experiment: Any, *, most_steps: int) -> None:
    """Raises RunError unless a task could be evolved.

    Args:
      task: that makes the experiment.
      experiment: that is to evolve: the task's, with its settings changed perhaps.
      most_steps: after which a trial that has not ended is taken for one that never does.
    """
    file = task.place()
    if not isinstance(experiment, Experiment):
        _try(file, "rollout", lambda: _check_rollout(file, experiment))
        return
    _check_settings(file, experiment)
    is_as_written = experiment.strategy == task.experiment.strategy
    chosen = task.place("strategy") if is_as_written else file
    given, population = _given(file, experiment), _population(file, chosen, experiment)
    genotype = jax.tree.map(lambda leaf: leaf[0], population)
    state = _check_functions(file, experiment, given, genotype)
    side_effects.check_leaks(task)
    before = side_effects.snapshot(task.module)  # now, as the first trace may fill a cache
    _check_repeats(file, experiment, given, genotype, state)
    side_effects.check_unchanged(task, before)
    _check_trials(file, experiment, given, population, most_steps)


def _check_settings(file: str, experiment: Experiment) -> None:
    """Raises RunError unless the settings of environment and controller can be kept."""
    for owner, function in ((experiment.env, "step"), (experiment.controller, "act")):
        for kind in type(owner).__mro__:
            parameters = vars(kind).get("__dataclass_params__")
            is_frozen = parameters is not None and parameters.frozen
            if kind is not type(owner) and not inspect.get_annotations(kind):
                continue
            if kind.__module__.startswith(MODULE) and not is_frozen:
                raise RunError(
                    f"{_place(file, owner, function)}: class {kind.__name__} must be a frozen "
                    "dataclass, so that a run can keep its settings; write "
                    "@dataclasses.dataclass(frozen=True, kw_only=True) above it"
                )


def _given(file: str, experiment: Experiment) -> Any:
    """Returns what one walker is given."""
    env = experiment.env
    trials = _try(
        file, "sample_trials", lambda: env.sample_trials(jax.random.key(0), NUM_TRIALS), env
    )
    if not isinstance(trials, Trials) or trials.num != NUM_TRIALS:
        raise RunError(
            f"{_place(file, env, 'sample_trials')}: sample_trials must return "
            f"mjxwalk.envs.Trials, with one row for each trial, got {shapes.shown(trials)}"
        )
    return jax.tree.map(jnp.asarray, trials.given(0))


def _population(file: str, chosen: str, experiment: Experiment) -> Any:
    """Returns the first population that the strategy asks for; checks the strategy.

    Args:
      file: of the task.
      chosen: where the strategy is chosen.
      experiment: that has it.
    """
    controller, size = experiment.controller, experiment.population_size
    template = _try(file, "template", controller.template, controller)
    leaves = jax.tree.leaves(template)
    if not leaves or any(not jnp.issubdtype(jnp.asarray(x).dtype, jnp.floating) for x in leaves):
        raise RunError(
            f"{_place(file, controller, 'template')}: template must return arrays of floats, "
            f"got {shapes.shown(template)}"
        )
    words = f"strategy {experiment.strategy.name}"
    strategy = _try(chosen, words, experiment.make_strategy)
    key = jax.random.key(1)
    state = _try(chosen, words, lambda: strategy.init(key, template))
    population, asked = _try(chosen, words, lambda: strategy.ask(key, state))
    wanted = jax.tree.map(lambda x: jax.ShapeDtypeStruct((size, *x.shape), x.dtype), template)
    shapes.check_same(
        chosen, f"{words}: ask", wanted, population, "the template with a population axis"
    )

    def tell(told: Any) -> Any:
        return strategy.tell(key, population, jnp.zeros(size), told)[0]

    after = _try(chosen, words, lambda: jax.eval_shape(tell, asked))
    shapes.check_same(chosen, f"{words}: tell", asked, after, "the state that it was given")
    return population


def _check_functions(file: str, experiment: Experiment, given: Any, genotype: Any) -> Any:
    """Traces each function of a walker alone, and returns the shapes of a state."""
    env, controller = experiment.env, experiment.controller
    state = _trace(file, env, "reset", lambda: env.reset(given))
    if not isinstance(getattr(state, "trial", None), TrialState):
        raise RunError(
            f"{_place(file, env, 'reset')}: the state that reset returns must have a "
            f"mjxwalk.envs.TrialState as trial, got {shapes.shown(state)}; start with "
            "TrialState.begin()"
        )
    qpos = getattr(state, "qpos", None)
    if len(getattr(qpos, "shape", ())) != 1:
        raise RunError(
            f"{_place(file, env, 'reset')}: the state that reset returns must have an array of one "
            f"axis as qpos, whose first number is how far the walker came, got {shapes.shown(qpos)}"
        )
    seen = _trace(file, env, "observe", lambda s: env.observe(s), state)
    names = getattr(env, "observation_names", None)
    if names is not None and jnp.shape(seen) != (len(names),):
        raise RunError(
            f"{_place(file, env, 'observe')}: observe must return an array of {len(names)} "
            f"numbers, as many as observation_names, got {shapes.shown(seen)}"
        )
    memory = _trace(file, controller, "init", lambda g: controller.init(g), genotype)
    acted = _trace(
        file, controller, "act", lambda g, m, o: controller.act(g, m, o), genotype, memory, seen
    )
    if not isinstance(acted, tuple) or len(acted) != 2:
        raise RunError(
            f"{_place(file, controller, 'act')}: act must return a new memory and an action, got "
            f"{shapes.shown(acted)}"
        )
    shapes.check_same(
        _place(file, controller, "act"), "act", memory, acted[0], "the memory of init"
    )
    names = getattr(env, "action_names", None)
    if names is not None and jnp.shape(acted[1]) != (len(names),):
        raise RunError(
            f"{_place(file, controller, 'act')}: act must return an action of {len(names)} "
            f"numbers, as many as the environment's action_names, got {shapes.shown(acted[1])}"
        )
    after = _trace(file, env, "step", lambda s, a: env.step(s, a, given), state, acted[1])
    shapes.check_same(
        _place(file, env, "step"), "step", state, after, "the state that reset returned"
    )
    fitness = _trace(file, env, "fitness", lambda s: env.fitness(s), state)
    if jnp.shape(fitness) != () or not jnp.issubdtype(fitness.dtype, jnp.floating):
        raise RunError(
            f"{_place(file, env, 'fitness')}: fitness must return one number, an array without "
            f"axes, got {shapes.shown(fitness)}"
        )
    return state


def _check_repeats(
    file: str, experiment: Experiment, given: Any, genotype: Any, state: Any
) -> None:
    """Raises RunError if a function computes something else when it is traced once more."""
    env, controller = experiment.env, experiment.controller
    seen = jax.eval_shape(lambda s: env.observe(s), state)
    memory = jax.eval_shape(lambda g: controller.init(g), genotype)
    action = jax.eval_shape(lambda *x: controller.act(*x), genotype, memory, seen)[1]
    functions: list[tuple[Any, str, Callable[..., Any], tuple[Any, ...]]] = [
        (env, "reset", lambda g: env.reset(g), (given,)),
        (env, "observe", lambda s: env.observe(s), (state,)),
        (controller, "act", lambda *x: controller.act(*x), (genotype, memory, seen)),
        (env, "step", lambda s, a, g: env.step(s, a, g), (state, action, given)),
        (env, "fitness", lambda s: env.fitness(s), (state,)),
    ]
    for owner, name, function, args in functions:
        place = blame.place_of(owner, name)
        if place is not None and _written(function, args) != _written(function, args):
            raise RunError(
                f"{place}: {name} computes something else each time it is traced; it may depend on "
                "its arguments alone, so use jax.random with a key from the state in place of "
                "Python's or NumPy's random numbers, and no clock and no counter"
            )


def _written(function: Callable[..., Any], args: tuple[Any, ...]) -> str:
    # A function that JAX has not met, as it remembers what it traced.
    closed = jax.make_jaxpr(lambda *x: function(*x))(*args)
    numbers = [np.asarray(const).tobytes() for const in closed.consts if hasattr(const, "dtype")]
    return f"{re.sub('0x[0-9a-f]+', '', str(closed))}{numbers}"


def _check_trials(
    file: str, experiment: Experiment, given: Any, population: Any, most_steps: int
) -> None:
    """Raises RunError unless a walker's trial ends within so many steps, with a fitness."""
    env = experiment.env
    if type(env).step.__module__.startswith("mjxwalk."):
        return  # its trials end after their longest time; to run one takes long to compile
    trial = FirstTrial(_place(file, env, "step"), experiment, given)
    for number in range(min(experiment.population_size, MOST_WALKERS)):
        genotype = jax.tree.map(lambda leaf, n=number: leaf[n], population)
        walk = _try(file, "step", lambda one=genotype: trial.run(one, most_steps), env)
        if np.isfinite(_try(file, "fitness", lambda walk=walk: env.fitness(walk.state), env)):
            return
    raise RunError(
        f"{_place(file, env, 'fitness')}: fitness is not a finite number for any of the first "
        "walkers at the end of their trials; look for a division by zero, or a step that diverges"
    )


def _check_rollout(file: str, experiment: Any) -> None:
    """Raises RunError unless another kind of experiment evaluates a walker and has a strategy."""
    strategy = experiment.make_strategy()
    population, _ = strategy.ask(
        jax.random.key(1), strategy.init(jax.random.key(1), experiment.template())
    )
    trials = experiment.sample_trials(jax.random.key(0), NUM_TRIALS, None)
    genotype = jax.tree.map(lambda leaf: leaf[0], population)
    outcome = jax.eval_shape(lambda g: experiment.rollout(g, trials.given(0)), genotype)
    if not isinstance(outcome, Outcome):
        place = _place(file, experiment, "rollout")
        raise RunError(f"{place}: rollout must return an Outcome, got {shapes.shown(outcome)}")
    for name, value in outcome._asdict().items():
        if value is not None and name != "sensed" and jnp.shape(value) != ():
            place = _place(file, experiment, "rollout")
            raise RunError(f"{place}: {name} must be one number, got {shapes.shown(value)}")


def _trace(file: str, owner: Any, name: str, function: Callable[..., Any], *args: Any) -> Any:
    return _try(file, name, lambda: jax.eval_shape(function, *args), owner)


def _try(file: str, what: str, function: Callable[[], Any], owner: Any = None) -> Any:
    """Returns what a function returns; an error in it is told with its place.

    Args:
      file: of the task.
      what: the function is, in a word.
      function: without arguments.
      owner: of the user's function; None where there is none.
    """
    try:
        return function()
    except RunError:
        raise
    except Exception as error:
        place = _place(file, owner, what)
        told = blame.located(error) or f"{place}: {what} fails: {blame.message(error)}"
        raise RunError(told) from error


def _place(file: str, owner: Any, name: str) -> str:
    return (None if owner is None else blame.place_of(owner, name)) or file
