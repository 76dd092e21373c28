"""A lock of an open file that one process has at a time; the system frees it when that ends.

A library that locks an open file, and not a path that it opens itself, leaves it to the caller to
refuse a link there.
"""


def lock(descriptor: int, *, waits: bool) -> bool:
    """Locks an open file until it is closed, and returns whether no other process has the lock.

    Args:
      descriptor: of the file, which may be written.
      waits: for another process to unlock it; Windows gives up after ten seconds.

    Raises:
      OSError: the file system has no locks, or fails.
    """
    import portalocker  # most commands lock nothing

    flags = portalocker.LockFlags.EXCLUSIVE
    try:
        portalocker.lock(descriptor, flags if waits else flags | portalocker.LockFlags.NON_BLOCKING)
    except portalocker.AlreadyLocked:
        return False
    except portalocker.LockException as error:
        reason = error.__cause__
        raise reason if isinstance(reason, OSError) else OSError(str(error)) from error
    return True
