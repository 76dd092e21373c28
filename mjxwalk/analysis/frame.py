"""The type of tables in signatures."""

from typing import Any, TypeAlias

# A pandas.DataFrame. pandas has no types of its own that fit strict checking, and importing it here
# would cost every command a third of a second.
Frame: TypeAlias = Any
