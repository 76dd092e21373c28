"""Tests of payloads, against bodies whose file has the mass fixed to the torso."""

import dataclasses
import re
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from mjxwalk.envs import Action, MjcfEnv, Payload, Planar7, Reil
from mjxwalk.robots import FOLDER

TOYS = Path(__file__).parents[1] / "toys"
FILES = {
    "toy": TOYS / "toy_biped.xml",
    "walker2d": FOLDER / "walker2d.xml",
    "h1": FOLDER / "h1.xml",
}
ON_BACK = Payload(share=0.2, spread=0.1, forward=-0.15, left=0.05, up=0.2)
NUM = 100


def welded(env: MjcfEnv, mass: float) -> str:
    """Returns a body's text with such a mass fixed where the payload is."""
    place = env.torso_centre.astype(float) + env.payload.offset
    inside = (
        f'<body name="bag" pos="{" ".join(map(str, place))}">'
        f'<inertial pos="0 0 0" mass="{mass}" diaginertia="1e-9 1e-9 1e-9"/></body>'
    )
    tag = rf'(<body [^>]*name="{env.anatomy.torso}"[^>]*>)(.*)'
    head, torso, rest = re.split(tag, env.body, maxsplit=1, flags=re.DOTALL)[:3]
    end = rest.rindex("</body>")
    return (
        f"{head}{torso}{rest[:end]}{inside}{rest[end:]}"
        + env.body[len(head) + len(torso) + len(rest) :]
    )


def walked(env: MjcfEnv, state: Any, given: Any) -> Any:
    """Returns where a body is after some steps under torques; numpy, float64."""
    strength: Any = np.array([each.strength for each in env.anatomy.motors])
    with jax.enable_x64(True):

        def step(number: Any, now: Any) -> Any:
            torque: Any = 0.2 * strength * jnp.sin(0.05 * number + np.arange(strength.size))
            none = jnp.zeros(strength.size)
            return env.step(now, Action(torque, none, none, none), given)

        run = jax.jit(lambda state: jax.lax.fori_loop(0, NUM, step, state))
        double = jax.tree.map(
            lambda leaf: leaf.astype(np.float64) if leaf.dtype == np.float32 else leaf,
            jax.device_get(state),
        )
        return jax.device_get(run(double))


@pytest.mark.parametrize("name", ["toy", "walker2d", pytest.param("h1", marks=pytest.mark.slow)])
def test_a_payload_is_a_mass_fixed_to_the_torso(name: str) -> None:
    text = FILES[name].read_text(encoding="utf-8")
    lenient: dict[str, Any] = {"max_flight_time": 9.0, "min_height": 0.01, "max_time": 9.0}
    env = MjcfEnv.of(text, payload=ON_BACK, acting="torque", **lenient)
    given = env.sample_trials(jax.random.key(3), 1).given(np.int32(0))
    state, load = jax.jit(env.reset)(given), float(np.asarray(given.load))
    mass = env.mass * (0.2 + 0.1 * load)
    bare = dataclasses.replace(env, payload=Payload())
    other = dataclasses.replace(bare, body=welded(env, mass))
    assert other.mass == pytest.approx(env.mass + mass, rel=1e-6)
    found, expected, light = (walked(each, state, given) for each in (env, other, bare))
    # Constants are float32, and the ground carries on what differs.
    np.testing.assert_allclose(found.qpos, expected.qpos, atol=2e-6)
    np.testing.assert_allclose(found.qvel, expected.qvel, atol=2e-4)
    assert np.abs(light.qpos - expected.qpos).max() > 1e-4 and expected.touching.any()


def test_the_same_key_draws_the_same_payload_and_changes_no_ground() -> None:
    env, key = Planar7(payload=ON_BACK), jax.random.key(7)
    one, again, without = (each.sample_trials(key, 50) for each in (env, env, Planar7()))
    np.testing.assert_array_equal(one.load, again.load)
    np.testing.assert_array_equal(one.heights, without.heights)
    assert without.load is None and env.level_trials().load is None
    masses = np.array([env.payload.mass(load, 10.0) for load in jnp.asarray(one.load)])
    assert 1.0 <= masses.min() < 1.2 and 2.8 < masses.max() <= 3.0


@pytest.mark.parametrize(
    ("settings", "complaint"),
    [
        ({"share": -0.1}, "share must be 0 or above, got -0.1"),
        ({"spread": 0.1}, "spread of a payload must be its share, 0.0, at most, .*, got 0.1"),
        ({"share": 0.1, "up": float("inf")}, "up must be from"),
    ],
)
def test_wrong_settings_are_refused(settings: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        Payload(**settings)


def test_a_body_with_a_load_of_its_own_refuses_a_payload() -> None:
    with pytest.raises(ValueError, match="payload must be none, as this body carries terrain.load"):
        Reil(payload=ON_BACK)


def test_words_say_what_is_carried() -> None:
    assert not Payload() and Payload().words() == ""
    assert ON_BACK.words() == "10 to 30 % of its mass"
