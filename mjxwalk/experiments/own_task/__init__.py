"""Tasks of a user's own: a Python file that makes an experiment, whose text a run keeps."""

from mjxwalk.experiments.own_task import examples, trust
from mjxwalk.experiments.own_task.blame import located
from mjxwalk.experiments.own_task.execution import MODULE, Task, of_run, of_user
from mjxwalk.experiments.own_task.naming import Named, check_syntax, find, is_task

__all__ = [
    "MODULE",
    "Named",
    "Task",
    "check_syntax",
    "examples",
    "find",
    "is_task",
    "located",
    "of_run",
    "of_user",
    "trust",
]
