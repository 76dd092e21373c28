"""How figures look, whatever the user has set up for figures of their own."""

import contextlib
from collections.abc import Generator


@contextlib.contextmanager
def own() -> Generator[None]:
    """Sets matplotlib's default style until the block ends; also a decorator.

    A `matplotlibrc` may ask for another style, for the locale's decimal commas, or for LaTeX.
    """
    import matplotlib  # which takes a third of a second, and a decorator is made on import

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        yield
