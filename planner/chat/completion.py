"""Read a model's answer in a chat completion: its text, and the JSON object in the text."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator
from typing import Any

from planner.chat.endpoint import EndpointError

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
