"""Check before any work that the language model's endpoint is configured."""

from scenarios.files.errors import BadInputError


def require_endpoint() -> None:
    """Check the environment variables.

    Raises:
        BadInputError: no endpoint is configured.
    """
    from planner.chat import endpoint_from_environment

    try:
        endpoint_from_environment()
    except ValueError as error:
        raise BadInputError(str(error)) from None
