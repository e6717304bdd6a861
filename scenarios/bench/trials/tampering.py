"""Tamper with inputs at random, feed them to their readers, and count how each ends.

Edits are of bytes, like those of a bad disk, and of JSON, like those of an attacker.
"""

from __future__ import annotations

import resource
import signal
import time
import traceback
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from rich.table import Table

from scenarios.files.outside_text import table_of

HANG_S = 5.0


class HangError(RuntimeError):
    """A reader took longer than the limit."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """An input to tamper with, and its reader.

    Attributes:
        tamper: Makes a random input.
        read: Reads the input as the commands do, and returns its content. ValueError and OSError
            refuse the input.
        is_changed: Tells whether the content that was read differs from that of the good input.
    """

    tamper: Callable[[np.random.Generator], object]
    read: Callable[[], Any]
    is_changed: Callable[[Any], bool]


@dataclass(kw_only=True)
class Tally:
    """The outcomes of one target's inputs.

    Attributes:
        slowest_s: The longest time of an input.
        grown_mb: Growth of the process's peak memory.
        ended: Number of "refused", "harmless", "changed", "traceback" and "hang".
        examples: The last lines of tracebacks, and the numbers of the inputs that led to them.
    """

    ended: Counter[str] = field(default_factory=Counter)
    examples: dict[str, int] = field(default_factory=dict)
    slowest_s: float = 0.0
    grown_mb: float = 0.0

    @property
    def is_good(self) -> bool:
        """Return whether no input did harm."""
        return not any(self.ended[how] for how in ("changed", "traceback", "hang"))


def tried(target: Target, inputs: int, seed: int) -> Tally:
    """Try a number of tampered inputs; input `k` is always the same."""
    tally, before_mb = Tally(), _peak_mb()
    for k in range(inputs):
        target.tamper(np.random.default_rng([seed, k]))
        start_s = time.perf_counter()
        how, why = _ended(target)
        tally.slowest_s = max(tally.slowest_s, time.perf_counter() - start_s)
        tally.ended[how] += 1
        if why:
            tally.examples.setdefault(why, k)
    tally.grown_mb = _peak_mb() - before_mb
    return tally


def _peak_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3


def _ended(target: Target) -> tuple[str, str]:
    try:
        with _time_limit():
            return ("changed", "accepted") if target.is_changed(target.read()) else ("harmless", "")
    except (ValueError, OSError) as error:
        return ("refused", "") if "\n" not in str(error) else ("traceback", f"lines: {error}")
    except HangError:
        return "hang", "hang"
    except Exception as error:  # an exception that is not a refusal is a fault to report
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return "traceback", f"{type(error).__name__}: {error} ({frame.filename}:{frame.lineno})"


@contextmanager
def _time_limit() -> Iterator[None]:
    def ring(*_: object) -> None:
        raise HangError

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, HANG_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def tally_table(tallies: dict[str, Tally]) -> Table:
    """Return a table with one row for each target."""
    columns = ("refused", "harmless", "changed", "traceback", "hang")
    figures = (*columns, "slowest (s)", "grown (MB)")
    table = table_of("tampered inputs", ("target",), figures, ())
    for name, tally in tallies.items():
        counts = [str(tally.ended[how]) for how in columns]
        table.add_row(name, *counts, f"{tally.slowest_s:.2f}", f"{tally.grown_mb:.0f}")
    return table


def summary_lines(tallies: dict[str, Tally]) -> list[str]:
    """Return the peak memory, and an example of each way in which an input did harm."""
    hurt = [
        f"{name}, input {k}: {why}" for name, t in tallies.items() for why, k in t.examples.items()
    ]
    return [f"peak memory of the process: {_peak_mb() / 1e3:.2f} GB", *hurt]


# Random edits


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
