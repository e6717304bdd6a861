"""Strict JSON of dataclasses and arrays, without NaN, because JSON has none."""

import json
import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from os import PathLike, fspath
from typing import Any


def plain(value: Any) -> Any:
    """Return `value` as dicts, lists, strings, numbers, booleans and None.

    Dataclasses become dicts, arrays nested lists, paths strings. A number that is infinite or not a
    number becomes None.

    Raises:
        TypeError: `value` holds anything else.
    """
    if isinstance(value, type):
        raise TypeError(f"the type {value.__name__} has no JSON form")
    if is_dataclass(value):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(entry) for entry in value]
    if isinstance(value, PathLike):
        return fspath(value)
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    raise TypeError(f"{type(value).__name__} has no JSON form: {value!r}")


def dumps(value: Any, indent: int | None = None) -> str:
    """Return the strict JSON text of `value`."""
    return json.dumps(plain(value), allow_nan=False, indent=indent, ensure_ascii=False)
