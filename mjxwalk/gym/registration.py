"""Names of the tasks for gymnasium."""

import importlib.util

from mjxwalk.envs import BODIES


def register() -> None:
    """Makes the tasks known to gymnasium, where it is installed."""
    if importlib.util.find_spec("gymnasium") is None:
        return
    import gymnasium

    for body in BODIES:
        name = f"mjxwalk/{body}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="mjxwalk.gym.environments:WalkerEnv",
                vector_entry_point="mjxwalk.gym.environments:WalkerVectorEnv",
                kwargs={"body": body},
            )
