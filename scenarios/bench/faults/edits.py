"""Random edits: of bytes, like those of a bad disk, and of JSON, like those of an attacker."""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from typing import Any

import numpy as np

NASTY: tuple[Any, ...] = (
    None, True, -1, 0, 7, 99, 2**31, 10**9, 10**30, -0.5, 1e308, "", "x", "yes", "NaN", [], {},
    [[]], ["x"], [None], {"x": None}, "../../x", "os:system", "[/foo]",
)  # fmt: skip


def flipped(content: bytes, chance: np.random.Generator) -> bytes:
    """Return the content with some bytes changed, cut off, taken out or repeated."""
    edited, at = bytearray(content), int(chance.integers(max(len(content), 1)))
    match chance.integers(5):
        case 0:
            return content[:at]
        case 1:
            return content[:at] + content[at + 1 + chance.integers(64) :]
        case 2:
            return content[:at] + content[at : at + 32] + content[at:]
        case _:
            for k in chance.integers(len(edited), size=chance.integers(1, 9)) if edited else ():
                edited[k] ^= 1 << int(chance.integers(8))
            return bytes(edited)


def restructured(tree: Any, chance: np.random.Generator) -> Any:
    """Return a JSON value with one of its parts removed or replaced by an invalid value."""
    edited = deepcopy(tree)
    places = list(_places(edited))
    if not places:
        return deepcopy(NASTY[chance.integers(len(NASTY))])
    node, key = places[chance.integers(len(places))]
    if chance.random() < 0.25:
        del node[key]
    else:
        node[key] = deepcopy(NASTY[chance.integers(len(NASTY))])
    return edited


def _places(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield each part of a value as its parent and its key; parts of the top level come twice."""
    keys = node if isinstance(node, dict) else range(len(node)) if isinstance(node, list) else ()
    for key in keys:
        yield node, key
        yield from _places(node[key])
