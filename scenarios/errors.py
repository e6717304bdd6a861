"""What can go wrong around an episode, in one line."""


class BadInputError(ValueError):
    """What a person asked for cannot be done; names the value and what is allowed (exit 2)."""


class WorkerDiedError(RuntimeError):
    """The process that ran an episode ended without a result."""


def describe_error(error: BaseException) -> str:
    """Returns the type and message of `error`."""
    return f"{type(error).__name__}: {error}".rstrip(": ")
