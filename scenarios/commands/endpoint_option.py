"""Whether the language model's endpoint is known, found out before any work is done."""

from scenarios.files.errors import BadInputError


def require_endpoint(planner: str) -> None:
    """Checks the environment, if this planner needs an endpoint.

    Raises:
        BadInputError: It needs one and none is named.
    """
    if planner != "llm":
        return
    from planner.chat import endpoint_from_environment

    try:
        endpoint_from_environment()
    except ValueError as error:
        raise BadInputError(str(error)) from None
