"""Read JSON text from an untrusted source: finite numbers only, and no deep nesting."""

from __future__ import annotations

import json
import math
from typing import Any, NoReturn

LARGEST = 2**63  # a whole number is smaller


def from_json(text: str | bytes) -> Any:
    """Return the content of a JSON text.

    Raises:
        ValueError: The text is not JSON, or has NaN, an infinite or a huge number, or deep nesting.
    """
    try:
        return json.loads(text, parse_constant=_refuse, parse_float=_finite, parse_int=_whole)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    except TypeError:
        raise ValueError(f"it is a {type(text).__name__}, not text") from None


def _refuse(name: str) -> NoReturn:
    raise ValueError(f"{name} is no number of JSON")


def _finite(text: str) -> float:
    if not math.isfinite(number := float(text)):
        raise ValueError(f"{text:.20} is infinite")
    return number


def _whole(text: str) -> int:
    if len(text) > len(str(LARGEST)) or abs(number := int(text)) >= LARGEST:
        raise ValueError(f"{text:.20}... is a huge number")
    return number
