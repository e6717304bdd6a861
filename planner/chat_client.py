"""Ask a language model by the chat-completions protocol within a time limit; read its answer.

The answer is a chat completion, which holds a text, which holds a JSON object.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime
from typing import Any

from planner.chat_endpoint import TIMEOUT, Endpoint, EndpointError, Reply, post

WAITS_S = (0.5, 1.0)  # wall-clock time before the second and the third attempt
REFUSES = (400, 422)  # status of a server that does not know a part of the request
PASSING = (408, 425, 429)  # status of a server that may answer later, as all from 500 on


class ChatClient:
    """Asks an endpoint; refused parts of a request are left out of later requests."""

    def __init__(
        self,
        endpoint: Endpoint,
        schema: Mapping[str, Any],
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        """Request answers that keep a JSON schema, as far as the endpoint supports schemas."""
        self.endpoint, self._sleep = endpoint, sleep
        form = {"name": "instruction", "strict": True, "schema": schema}
        self._options: dict[str, Any] = {
            "temperature": 0,
            "seed": 0,
            "response_format": {"type": "json_schema", "json_schema": form},
        }

    def ask(self, system: str, question: str) -> str:
        """Return the text of the answer.

        Raises:
            EndpointError: There is no answer within the time limit. The message names the reason
                and the endpoint.
            NonsenseError: The model's answer is empty.
        """
        until_s = time.monotonic() + self.endpoint.timeout_s
        messages = [
            {"role": "system", "content": system},
            {"role": "user", "content": question},
        ]
        try:
            return self._patiently(messages, until_s)
        except EndpointError as error:
            raise EndpointError(f"{self.endpoint.name}: {self._told(error)}") from None
        except TimeoutError:
            limit = f"no answer within {self.endpoint.timeout_s:g} s ({TIMEOUT})"
            raise EndpointError(f"{self.endpoint.name}: {limit}") from None

    def _patiently(self, messages: list[dict[str, str]], until_s: float) -> str:
        """Return the answer; ask again while the fault may pass and time is left."""
        for wait_s in WAITS_S:
            try:
                return self._once(messages, until_s)
            except EndpointError as error:
                wait_s = max(wait_s, error.after_s)
                if not error.passing:
                    raise
                if time.monotonic() + wait_s > until_s:
                    raise EndpointError(f"{error}{_too_late(error.after_s)}") from None
            self._sleep(wait_s)
        return self._once(messages, until_s)

    def _once(self, messages: list[dict[str, str]], until_s: float) -> str:
        reply = self._post(messages, until_s)
        while reply.status in REFUSES and self._options:
            self._leave_out(reply.words)
            reply = self._post(messages, until_s)
        _require_success(reply)
        return text_in(reply.content)

    def _leave_out(self, words: str) -> None:
        """Leave out the options that a refusal names, or all options if it names none."""
        named = [name for name in self._options if name in words]
        if "schema" in words:
            named.append("response_format")
        for name in named or tuple(self._options):
            self._options.pop(name, None)

    def _post(self, messages: list[dict[str, str]], until_s: float) -> Reply:
        headers = {"Content-Type": "application/json", "Accept": "application/json"}
        if self.endpoint.key:
            headers["Authorization"] = f"Bearer {self.endpoint.key}"
        body = {"model": self.endpoint.model, "messages": messages, **self._options}
        address = self.endpoint.url.rstrip("/") + "/chat/completions"
        return post(address, json.dumps(body).encode(), headers, until_s - time.monotonic())

    def _told(self, error: EndpointError) -> str:
        """Return an error's words without the key, which a server may repeat."""
        key = self.endpoint.key
        return str(error).replace(key, "...") if key else str(error)


def _require_success(reply: Reply) -> None:
    """Check that a reply belongs to an accepted request.

    Raises:
        EndpointError: The request was refused; the message has the server's words.
    """
    reason = "and sends elsewhere" if 300 <= reply.status < 400 else reply.reason
    why = f"it answered {reply.status} {reason}" + (reply.words and f": {reply.words}")
    if reply.status != 200:
        passing = reply.status in PASSING or reply.status >= 500
        after_s = _seconds_after(reply.headers.get("Retry-After", ""))
        raise EndpointError(why, passing=passing, after_s=after_s)
    if reply.kind != "application/json":
        raise EndpointError(f"it answered {reply.kind}, not application/json")


def _seconds_after(said: str) -> float:
    """Return a server's wanted waiting time, from its seconds or date; 0 if it has neither."""
    if said.strip().isdecimal():
        return float(said)
    try:
        return (parsedate_to_datetime(said) - datetime.now(UTC)).total_seconds()
    except (TypeError, ValueError):
        return 0.0


def _too_late(after_s: float) -> str:
    return f"; it wants to be asked after {after_s:.0f} s, too late ({TIMEOUT})" if after_s else ""


# The answer

MAX_BRACES = 100  # places where an object may begin; an answer has few
_DECODER = json.JSONDecoder()


class NonsenseError(ValueError):
    """A model's answer cannot be followed; the message gives the reason in one line."""


def text_in(content: bytes) -> str:
    """Return the text of a completion, given in one piece or in parts.

    Raises:
        EndpointError: The content is no chat completion.
        NonsenseError: The model's answer is empty.
    """
    try:
        message = json.loads(content)["choices"][0]["message"]
        said = message["content"] or message.get("refusal") or ""
    except (ValueError, RecursionError):
        raise EndpointError("it answered no JSON") from None
    except (LookupError, TypeError, AttributeError):
        raise EndpointError("its answer is no chat completion") from None
    text = said if isinstance(said, str) else "".join(_parts(said))
    if not text.strip():
        raise NonsenseError("its answer has no text")
    return text


def _parts(said: Any) -> Iterator[str]:
    for part in said if isinstance(said, list) else ():
        if isinstance(part, dict) and isinstance(text := part.get("text"), str):
            yield text


def object_in(text: str, keys: Collection[str]) -> dict[str, Any]:
    """Return the JSON object with these keys in a text, in a fence or among prose.

    The model's reasoning before the answer, up to </think>, does not count.

    Raises:
        NonsenseError: There is no such object, or there are several that differ.
    """
    spoken = text.rpartition("</think>")[2].partition("<think>")[0]
    found = [thing for thing in _objects(spoken) if set(keys) <= thing.keys()]
    if not found:
        said = spoken.strip() or text
        raise NonsenseError(f"its answer is no JSON with {', '.join(keys)}: {said[:80]!r}")
    if any(other != found[0] for other in found):
        raise NonsenseError("it gives several answers that differ")
    return found[0]


def _objects(text: str) -> Iterator[dict[str, Any]]:
    at = 0
    for _ in range(MAX_BRACES):
        if (at := text.find("{", at)) < 0:
            return
        try:
            thing, at = _DECODER.raw_decode(text, at)
            yield thing
        except (ValueError, RecursionError):
            at += 1
