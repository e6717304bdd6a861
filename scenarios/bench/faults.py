"""The kinds of faults of `calot bench faults`; a new kind is a function, and a line in `KINDS`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from scenarios.bench.trials.fault_trial import process_faults
from scenarios.bench.trials.file_faults import FILES
from scenarios.bench.trials.page_faults import page_faults
from scenarios.bench.trials.tampering import Tally, tried
from scenarios.bench.trials.text_faults import TEXTS


@dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of faults.

    Attributes:
        tally: Tries a number of faults of a seed, and returns a tally for each target.
        inputs: Default number of inputs.
    """

    tally: Callable[[int, int], dict[str, Tally]]
    inputs: int


def tampered_files(inputs: int, seed: int) -> dict[str, Tally]:
    """Try tampered files, the same number of each kind of file."""
    tallies = {}
    for name, make in FILES.items():
        with TemporaryDirectory(prefix="calot-faults-") as folder:
            tallies[name] = tried(make(Path(folder)), -(-inputs // len(FILES)), seed)
    return tallies


def hostile_texts(inputs: int, seed: int) -> dict[str, Tally]:
    """Try hostile texts, the same number of each kind."""
    return {name: tried(make(), -(-inputs // len(TEXTS)), seed) for name, make in TEXTS.items()}


def hurt_commands(inputs: int, seed: int) -> dict[str, Tally]:
    """Interfere with running commands: kills, signals, a full disk, a folder that vanishes."""
    tallies: dict[str, Tally] = {}
    for fault in process_faults(seed, inputs):
        tally = tallies.setdefault(fault.command, Tally())
        tally.ended["changed" if fault.wrong else "harmless"] += 1
        for law in fault.wrong:
            tally.examples.setdefault(f"{fault.fault}: {law}", fault.seed)
    return tallies


def hostile_clients(inputs: int, seed: int) -> dict[str, Tally]:
    """Send a page requests that no browser would send."""
    tallies: dict[str, Tally] = {}
    for ended, count in page_faults(seed, inputs).items():
        client, _, outcome = ended.partition(": ")
        how = HOW_CLIENTS_END.get(outcome, "changed")
        tally = tallies.setdefault(client, Tally())
        tally.ended[how] += count
        if how not in ("refused", "harmless"):
            tally.examples.setdefault(outcome, seed)
    return tallies


HOW_CLIENTS_END = {"answered": "refused", "left": "harmless", "hung": "hang"}

KINDS: dict[str, Kind] = {
    "files": Kind(tally=tampered_files, inputs=5000),
    "texts": Kind(tally=hostile_texts, inputs=5000),
    "clients": Kind(tally=hostile_clients, inputs=500),
    "processes": Kind(tally=hurt_commands, inputs=60),
}
"""The kinds of faults that `calot bench faults` can try, by name."""
