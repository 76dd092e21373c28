"""Names of the tasks for gymnasium."""

import importlib.util

from mjxwalk.gym import bodies


def register() -> None:
    """Makes the tasks known to gymnasium, where it is installed."""
    if importlib.util.find_spec("gymnasium") is None:
        return
    import gymnasium

    for title, body in bodies.tasks().items():
        name = f"mjxwalk/{title}-v0"
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="mjxwalk.gym.environments:WalkerEnv",
                vector_entry_point="mjxwalk.gym.environments:WalkerVectorEnv",
                kwargs={"body": body},
            )
