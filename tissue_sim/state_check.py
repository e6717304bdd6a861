"""Check that a state is complete, of the right types, and within bounds.

The whole state is checked before any of it is restored, so a refused state changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, is_dataclass
from fnmatch import fnmatchcase
from numbers import Integral, Real
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

KINDS = {  # the types accepted for a Python type, including NumPy's scalars
    bool: (bool, np.bool_),
    int: Integral,
    float: Real,
}


@dataclass(frozen=True, kw_only=True)
class Bound:
    """The allowed values of a number, an array of numbers or a name; `low` and `high` included."""

    low: Any = -np.inf
    high: Any = np.inf
    shape: tuple[int, ...] | None = None
    names: tuple[str, ...] | None = None


def require_like(given: Any, example: Any, path: str) -> None:
    """Check that a state has the keys, types and shapes of an example, and finite arrays.

    Data classes are checked against the types of their fields, because their contents vary.

    Raises:
        ValueError: the state does not match the example.
    """
    if isinstance(example, dict):
        _require(isinstance(given, dict), path, brief(given), "dict")
        require_names(set(given), set(example), path)
        for name, part in example.items():
            require_like(given[name], part, f"{path}/{name}")
    elif isinstance(example, tuple):
        same = isinstance(given, tuple) and len(given) == len(example)
        _require(same, path, brief(given), f"tuple of {len(example)}")
        for k, part in enumerate(example):
            require_like(given[k], part, f"{path}/{k}")
    elif isinstance(example, np.ndarray):
        _require(brief(given) == brief(example), path, brief(given), brief(example))
        _require_finite(given, path)
    else:
        plain = example.item() if isinstance(example, np.generic) else example
        require_type(given, type(plain), path)


def require_type(given: Any, kind: Any, path: str) -> None:
    """Check that a value and all its parts are of a type, and finite.

    Args:
        given: the value.
        kind: a type, as in the annotation of a data class's field.
        path: name of the value in the message.

    Raises:
        ValueError: the value is not of this type, or not finite.
    """
    origin, parts = get_origin(kind), get_args(kind)
    if origin is UnionType:
        _require_any(given, parts, path)
        return
    expected = origin or kind
    _require(isinstance(given, KINDS.get(expected, expected)), path, brief(given), str(kind))
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        require_names(set(vars(given)), set(hints), path)
        for name, hint in hints.items():
            require_type(getattr(given, name), hint, f"{path}/{name}")
    elif origin in (tuple, frozenset):
        several = parts[-1] is Ellipsis or origin is frozenset
        _require(several or len(given) == len(parts), path, brief(given), str(kind))
        for k, part in enumerate(given):
            require_type(part, parts[0], f"{path}/{k}")
    elif origin is np.ndarray or kind is float:
        _require_finite(given, path)


def require_names(given: set[Any], expected: set[str], path: str) -> None:
    """Check that a state has exactly the expected parts.

    Raises:
        ValueError: a part is missing or unknown.
    """
    for odd, verb in ((expected - given, "missing"), (given - expected, "unknown")):
        if odd:
            raise ValueError(f"{path}: {verb}: {', '.join(sorted(map(str, odd)))}")


def require_within(given: Any, bounds: Mapping[str, Bound], path: str) -> None:
    """Check a state's numbers and names against every bound whose pattern matches their path.

    Raises:
        ValueError: a number or a name is out of its bounds.
    """
    leaves = list(_leaves(given, path))
    for pattern, bound in bounds.items():
        for where, value in leaves:
            if fnmatchcase(where, f"{path}/{pattern}"):
                _require_bound(np.asarray(value), bound, where)


def brief(value: Any) -> str:
    """Describe a value within a line: names, numbers and None as they are, others by their type."""
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, tuple):
        return f"tuple of {len(value)}"
    plain = value is None or isinstance(value, str | Real)
    return f"{value!r:.40}" if plain else type(value).__name__


def _require_bound(value: Any, bound: Bound, path: str) -> None:
    if bound.names is not None:
        _require(value in bound.names, path, repr(str(value)), f"one of {bound.names}")
        return
    if bound.shape is not None:
        _require(value.shape == bound.shape, path, f"of shape {value.shape}", str(bound.shape))
    low, high = np.broadcast_to(bound.low, value.shape), np.broadcast_to(bound.high, value.shape)
    for at in np.argwhere((value < low) | (value > high))[:1]:
        k = tuple(at.tolist())
        _require(False, f"{path}{list(k)}", str(value[k]), f"{low[k]} to {high[k]}")


def _require_any(given: Any, kinds: tuple[Any, ...], path: str) -> None:
    fits = [k for k in kinds if isinstance(given, get_origin(k) or KINDS.get(k, k))]
    _require(bool(fits), path, brief(given), " or ".join(map(str, kinds)))
    require_type(given, fits[0], path)


def _require_finite(given: Any, path: str) -> None:
    numbers = np.asarray(given)
    finite = numbers.dtype.kind in "biuf" and np.isfinite(numbers).all()
    _require(bool(finite), path, "not finite everywhere", "finite numbers")


def _require(fits: bool, path: str, found: str, expected: str) -> None:
    if not fits:
        raise ValueError(f"{path}: it is {found}; expected: {expected}")


def _leaves(node: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield path and value of every array, name and number; a tuple of numbers is one array."""
    if is_dataclass(node):
        node = vars(node)
    if isinstance(node, tuple) and not all(isinstance(part, Real) for part in node):
        node = dict(enumerate(node))
    if isinstance(node, dict):
        for name, part in node.items():
            yield from _leaves(part, f"{path}/{name}")
    else:
        yield path, node
