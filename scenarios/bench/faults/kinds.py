"""The kinds of faults of `calot bench faults`; a new one is a function, and a line here."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from scenarios.bench.faults.files import FILES
from scenarios.bench.faults.trial import Tally, tried


def tampered_files(inputs: int, seed: int) -> dict[str, Tally]:
    """Try tampered files, as many of each kind of file."""
    tallies = {}
    for name, make in FILES.items():
        with TemporaryDirectory(prefix="calot-faults-") as folder:
            tallies[name] = tried(make(Path(folder)), -(-inputs // len(FILES)), seed)
    return tallies


KINDS: dict[str, Callable[[int, int], dict[str, Tally]]] = {"files": tampered_files}
