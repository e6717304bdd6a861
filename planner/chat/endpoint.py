"""Describe the endpoint of a language model, with OpenAI's chat-completions protocol."""

from __future__ import annotations

import math
import os
from dataclasses import dataclass
from urllib.parse import unquote, urlsplit

URL, MODEL, KEY = "CALOT_LLM_URL", "CALOT_LLM_MODEL", "CALOT_LLM_KEY"
TIMEOUT, TIMEOUT_S = "CALOT_LLM_TIMEOUT", 10.0  # the variable, and its default


class EndpointError(RuntimeError):
    """No model answers: the endpoint is down, refuses, or breaks the protocol; in one line.

    Attributes:
        passing: Whether the error may be over at the next request.
        after_s: Waiting time that the endpoint wants; 0 if the endpoint names none.
    """

    def __init__(self, why: str, *, passing: bool = True, after_s: float = 0.0) -> None:
        super().__init__(why)
        self.passing, self.after_s = passing, after_s


@dataclass(frozen=True, kw_only=True)
class Endpoint:
    """The address of a model, and its settings.

    Attributes:
        url: Base of the API, to which "/chat/completions" is added.
        model: Name of the model at the endpoint.
        key: Key that is sent as a bearer token; "" for none. No file and no message has the key.
        timeout_s: Wall-clock time for a whole answer, including all repeated requests.

    Raises:
        ValueError: The address is not an http or https address, the model is missing, or the time
            is not above 0.
    """

    url: str
    model: str
    key: str = ""
    timeout_s: float = TIMEOUT_S

    def __post_init__(self) -> None:
        if not _is_address(self.url):
            raise ValueError(
                f"{URL} must be an address like https://host/v1, in ASCII, got {self.url!r}"
            )
        if not self.model:
            raise ValueError(f"{MODEL} must name a model")
        if not (self.key.isascii() and self.key.isprintable()):
            raise ValueError(f"{KEY} must be printable ASCII")
        if not 0.0 < self.timeout_s < math.inf:
            raise ValueError(f"{TIMEOUT} must be a number of seconds above 0, got {self.timeout_s}")

    @property
    def name(self) -> str:
        """Return the model and the host for a person to read, without the rest of the address."""
        return f"{self.model} at {urlsplit(self.url).hostname}"

    def __repr__(self) -> str:
        return f"Endpoint({self.name})"


def endpoint_from_environment() -> Endpoint:
    """Return the endpoint that `URL`, `MODEL` and, if wanted, `KEY` and `TIMEOUT` name.

    Raises:
        ValueError: A variable is missing or wrong. The message is one line.
    """
    if missing := [name for name in (URL, MODEL) if not os.environ.get(name)]:
        raise ValueError(
            f"planner 'llm' needs an endpoint: set {' and '.join(missing)}"
            f" (an address like https://host/v1, a model's name), and {KEY} where it wants a key"
        )
    return Endpoint(
        url=os.environ[URL],
        model=os.environ[MODEL],
        key=os.environ.get(KEY, "").strip(),
        timeout_s=_seconds(os.environ.get(TIMEOUT) or str(TIMEOUT_S)),
    )


def _seconds(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError(f"{TIMEOUT} must be a number of seconds, got {text!r}") from None


def _is_address(url: str) -> bool:
    """Return whether a request can be sent to this address.

    urllib decodes the host, takes a user before the host for a part of it, and sends ASCII only.
    """
    try:
        parts = urlsplit(url)
        host = unquote(parts.hostname or "")
        known = parts.scheme in ("http", "https") and host.encode("idna") and parts.port != 0
    except ValueError:
        return False
    is_plain = (url + host).isascii() and url.isprintable() and " " not in url
    return bool(known) and is_plain and "@" not in parts.netloc
