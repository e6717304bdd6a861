"""Client of an endpoint with OpenAI's chat-completions protocol: one question, one JSON answer."""

from __future__ import annotations

import json
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass
from http.client import HTTPException
from typing import Any
from urllib.error import HTTPError
from urllib.parse import unquote, urlsplit
from urllib.request import HTTPRedirectHandler, Request, build_opener

MAX_BYTES = 1_000_000
URL, MODEL, KEY = "CALOT_LLM_URL", "CALOT_LLM_MODEL", "CALOT_LLM_KEY"


class NoAnswerError(RuntimeError):
    """Why there is no answer, in one line.

    Attributes:
        passing: the fault is temporary; asking again may help.
    """

    def __init__(self, why: str, *, passing: bool = True) -> None:
        super().__init__(why)
        self.passing = passing


@dataclass(frozen=True, kw_only=True)
class Endpoint:
    """Where to ask.

    Attributes:
        url: base of the API, to which "/chat/completions" is added.
        model: name of the model there.
        key: sent as a bearer token; "" for none. It is written to no file and no message.
        timeout_s: wall-clock time for the answer; up to twice as long if its last part is late.

    Raises:
        ValueError: the address is not an http or https address, or the model is missing.
    """

    url: str
    model: str
    key: str = ""
    timeout_s: float = 10.0

    def __post_init__(self) -> None:
        if not _is_address(self.url):
            raise ValueError(
                f"{URL} must be an address like https://host/v1, in ASCII, got {self.url!r}"
            )
        if not self.model:
            raise ValueError(f"{MODEL} must name a model")
        if not (self.key.isascii() and self.key.isprintable()):
            raise ValueError(f"{KEY} must be printable ASCII")

    @property
    def name(self) -> str:
        """Return the model and the host for a person to read, without the rest of the address."""
        return f"{self.model} at {urlsplit(self.url).hostname}"

    def __repr__(self) -> str:
        return f"Endpoint({self.name})"

    def ask(self, system: str, question: str, schema: Mapping[str, Any]) -> Any:
        """Return the parsed answer. The endpoint may ignore the schema: the caller must check it.

        Raises:
            NoAnswerError: no answer comes, or it is not JSON, or it breaks the protocol.
        """
        body = {
            "model": self.model,
            "temperature": 0,
            "seed": 0,
            "messages": [
                {"role": "system", "content": system},
                {"role": "user", "content": question},
            ],
            "response_format": {
                "type": "json_schema",
                "json_schema": {"name": "instruction", "strict": True, "schema": schema},
            },
        }
        return _content(self._post(json.dumps(body).encode()))

    def _post(self, body: bytes) -> bytes:
        headers = {"Content-Type": "application/json", "Accept": "application/json"}
        if self.key:
            headers["Authorization"] = f"Bearer {self.key}"
        address = self.url.rstrip("/") + "/chat/completions"
        request = Request(address, data=body, headers=headers, method="POST")
        until_s = time.monotonic() + self.timeout_s
        try:
            with _OPENER.open(request, timeout=self.timeout_s) as answer:
                kind = answer.headers.get_content_type()
                if kind != "application/json":
                    raise NoAnswerError(f"it answered {kind}, not application/json")
                return _read(answer, until_s)
        except HTTPError as error:
            passing = error.code in (408, 429) or error.code >= 500
            raise NoAnswerError(
                f"it answered {error.code} {error.reason}", passing=passing
            ) from None
        except TimeoutError:
            raise NoAnswerError(f"no answer within {self.timeout_s:g} s") from None
        except (OSError, HTTPException) as error:
            reason = getattr(error, "reason", None) or error
            if isinstance(reason, TimeoutError):
                raise NoAnswerError(f"no answer within {self.timeout_s:g} s") from None
            raise NoAnswerError(f"it cannot be reached: {reason}") from None


def endpoint_from_environment() -> Endpoint:
    """Return the endpoint that the variables `URL`, `MODEL` and, if needed, `KEY` name.

    Raises:
        ValueError: a variable is missing or wrong; the message is one line.
    """
    if missing := [name for name in (URL, MODEL) if not os.environ.get(name)]:
        raise ValueError(
            f"planner 'llm' needs an endpoint: set {' and '.join(missing)}"
            f" (an address like https://host/v1, a model's name), and {KEY} where it wants a key"
        )
    return Endpoint(
        url=os.environ[URL], model=os.environ[MODEL], key=os.environ.get(KEY, "").strip()
    )


def _is_address(url: str) -> bool:
    """Return whether a request can be sent there.

    urllib decodes the host, takes a user before it for a part of it, and sends ASCII only.
    """
    try:
        parts = urlsplit(url)
        host = unquote(parts.hostname or "")
        known = parts.scheme in ("http", "https") and host.encode("idna") and parts.port != 0
    except ValueError:
        return False
    is_plain = (url + host).isascii() and url.isprintable() and " " not in url
    return bool(known) and is_plain and "@" not in parts.netloc


class _NoRedirect(HTTPRedirectHandler):
    """Refuses redirects, so that the key is sent to the named address only."""

    def redirect_request(self, req: Any, fp: Any, code: int, *_: Any) -> None:
        raise HTTPError(req.full_url, code, "and sends elsewhere", req.headers, fp)


_OPENER = build_opener(_NoRedirect)


def _read(answer: Any, until_s: float) -> bytes:
    """Read the whole answer; give up on an endpoint that sends too much or too slowly."""
    content = b""
    while part := answer.read1(65_536):
        content += part
        if len(content) > MAX_BYTES:
            raise NoAnswerError(f"its answer is longer than {MAX_BYTES} bytes")
        if time.monotonic() > until_s:
            raise TimeoutError
    return content


def _content(answer: bytes) -> Any:
    try:
        text = json.loads(answer)["choices"][0]["message"]["content"]
    except (ValueError, RecursionError):
        raise NoAnswerError("it answered no JSON") from None
    except (LookupError, TypeError):
        raise NoAnswerError("its answer is no chat completion") from None
    if not isinstance(text, str):
        raise NoAnswerError("its answer has no text")
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        raise NoAnswerError(f"its answer is no JSON: {text[:80]!r}") from None
