"""Check before any work that the language model's endpoint is configured, and answers."""

from scenarios.files.errors import BadInputError


def require_endpoint() -> None:
    """Check the environment variables, and ask the endpoint once.

    Raises:
        BadInputError: no endpoint is configured, or no model answers there.
    """
    from planner.chat.endpoint import EndpointError, endpoint_from_environment
    from planner.llm import require_answer

    try:
        require_answer(endpoint_from_environment())
    except (ValueError, EndpointError) as error:
        raise BadInputError(str(error)) from None
