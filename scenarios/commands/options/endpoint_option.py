"""Check before any work that the language model's endpoint is configured."""

from scenarios.files.errors import BadInputError


def require_endpoint(planner: str) -> None:
    """Check the environment variables, if this planner needs an endpoint.

    Raises:
        BadInputError: the planner needs an endpoint, and none is configured.
    """
    if planner != "llm":
        return
    from planner.chat import endpoint_from_environment

    try:
        endpoint_from_environment()
    except ValueError as error:
        raise BadInputError(str(error)) from None
