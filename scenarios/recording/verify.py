"""Check, file by file, whether a recorded episode is the same when it is run again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from shutil import rmtree
from tempfile import gettempdir
from typing import Literal
from uuid import uuid4

from rich.table import Table

from scenarios.files.errors import BAD_INPUT, ERROR, FAILED, WorkerDiedError
from scenarios.files.outside_text import table_of
from scenarios.files.versions import versions

Outcome = Literal["identical", "differs", "refused", "error"]

EXIT_CODES: dict[Outcome, int] = {
    "identical": 0,
    "differs": FAILED,
    "refused": BAD_INPUT,
    "error": ERROR,
}


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The outcome of verifying one file.

    Attributes:
        outcome: The same to the bit, different, not repeatable here, or its process died.
        remark: The length, the first difference and its size, or the reason for a refusal.
    """

    file: Path
    outcome: Outcome
    remark: str


def verify(file: Path, allowed: Set[str] | None = frozenset()) -> Verdict:
    """Run the episode of a recording again and compare.

    Policies MODULE:FACTORY of the recording run only if they are `allowed`; None allows all.
    """
    from scenarios.recording.first_difference import first_difference
    from scenarios.recording.recorder import load
    from scenarios.recording.rerun_decisions import repeat

    try:
        recorded = load(file)
        with _folder() as folder:
            again = repeat(recorded, folder, allowed)
    except OSError as error:
        return Verdict(file=file, outcome="refused", remark=f"{file}: {error.strerror or error}")
    except ValueError as error:
        remark = str(error) if str(file) in str(error) else f"{file}: {error}"
        return Verdict(file=file, outcome="refused", remark=remark)
    difference = first_difference(recorded, again)
    if difference is None:
        n_steps = len(recorded.arrays["time_s"])
        broke_off = f"; it broke off: {recorded.error}" if recorded.error else ""
        return Verdict(file=file, outcome="identical", remark=f"{n_steps} steps{broke_off}")
    remark = "; ".join([str(difference), *_changes(recorded.versions)])
    return Verdict(file=file, outcome="differs", remark=remark)


@contextmanager
def _folder() -> Iterator[Path]:
    """Yield a temporary folder that is made when the episode is saved, not before it runs.

    The folder is removed at once, so that a killed process hardly ever leaves one behind.
    """
    folder = Path(gettempdir(), f"calot-verify-{uuid4().hex}")
    try:
        yield folder
    finally:
        rmtree(folder, ignore_errors=True)


def lost(file: Path, death: WorkerDiedError) -> Verdict:
    """Return the verdict on a file whose process died."""
    return Verdict(file=file, outcome="error", remark=str(death))


def recordings_in(path: Path) -> list[Path]:
    """Return the recordings in a folder and its subfolders, or the file itself."""
    return sorted(path.rglob("*.npz")) if path.is_dir() else [path]


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """Return a table with one row for each file."""
    rows = ((str(v.file), v.outcome, v.remark) for v in verdicts)
    return table_of("recordings, run again", ("file", "outcome", ""), (), rows)


def _changes(recorded: dict[str, str]) -> Iterator[str]:
    """Yield the versions that differ here; the promise of equality does not cover them."""
    for name, here in versions().items():
        if recorded.get(name) != here:
            yield f"made with {name} {recorded.get(name, 'unknown')}, but here it is {here}"
