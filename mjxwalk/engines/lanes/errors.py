"""What the compiler says when it cannot."""


class CannotCompileError(NotImplementedError):
    """The function does something that the lanes engine has no machine code for."""
