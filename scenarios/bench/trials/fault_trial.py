"""Interfere with a running command at a random moment, and check its remains.

Four laws hold after every fault. No finished episode is lost. The exit code is the documented one.
No process and no temporary file remains. No lock remains.
"""

from __future__ import annotations

import json
import os
import resource
import shutil
import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from scenarios.bench.trials.calot_process import CalotProcess
from scenarios.commands.folder_options import claimed
from scenarios.files.errors import BAD_INPUT, BadInputError
from scenarios.files.sums import RESULTS
from scenarios.recording.recorder import load

EPISODES = 6
LATEST_S = 14.0  # most commands have ended by then on a machine that is not busy
GRACE_S = 10.0  # for the children of a killed parent, which save and end
NO_ROOM_BYTES = 500

_WHO = ["--workers", "2", "--episodes", str(EPISODES), "--seed", "10000"]
COMMANDS: dict[str, tuple[str, ...]] = {
    "run": (*("run", *_WHO, "--planner", "scripted", "--controller", "idle"), "--out", "out"),
    "evaluate": (*("evaluate", *_WHO, "--arms", "a=scripted+idle"), "--out", "out"),
    "verify": ("replay", "--verify", "out", "--workers", "2"),
}
# No tube has room: the robot calls a person at once, and the episode ends.
ENDS_SOON = ("--scenario", "short-tubes", "--magnitude", "1")
CONDITIONS: dict[str, tuple[tuple[str, ...], ...]] = {
    "run": (ENDS_SOON, ("--scenario", "nominal")),
    "evaluate": (("--suite", "nominal"),),
}
USUAL = (0, 1)  # every episode has a result; also if a signal comes after the last one


@dataclass(frozen=True, kw_only=True)
class ProcessFault:
    """The fault of a command, and the laws that it broke.

    Attributes:
        when_s: Time after the command became stoppable.
        exit_code: The exit code; a negative one is the number of the signal that killed the
            command.
        wrong: One line for each law that was broken.
    """

    seed: int
    command: str
    fault: str
    when_s: float
    exit_code: int
    wrong: tuple[str, ...]


def process_faults(seed: int, n: int) -> Iterator[ProcessFault]:
    """Yield the outcomes of `n` faults, one after another; each is drawn from its own seed."""
    with TemporaryDirectory(prefix="calot-faults-") as root:
        recorded = Path(root, "recorded")
        _record(recorded)
        for k in range(seed, seed + n):
            yield _tried(k, Path(root, str(k)), recorded)


def _tried(seed: int, folder: Path, recorded: Path) -> ProcessFault:
    rng = np.random.default_rng([0xFA017, seed])
    command, fault = str(rng.choice(list(COMMANDS))), str(rng.choice(list(FAULTS)))
    words = list(COMMANDS[command])
    if command in CONDITIONS:
        words += CONDITIONS[command][rng.integers(len(CONDITIONS[command]))]
    else:
        shutil.copytree(recorded, folder)
    when_s = float(rng.uniform(0.0, LATEST_S))
    with CalotProcess(words=words, folder=folder) as process:
        process.wait_until_stoppable()
        time.sleep(when_s)
        hurt = process.is_running
        if hurt:
            FAULTS[fault][0](process, rng)
        code, _, err = process.end()
        wrong = (
            *_wrong_exit(code, fault if hurt else "none", err),
            *_left(process, GRACE_S if fault == "kill" else 0.5),
            *_lost(folder, counted=command == "run" and fault != "kill"),
            *(_unanswered(folder) if code in USUAL and FAULTS[fault][1][0] > 128 else ()),
        )
    if command == "evaluate" and fault == "kill":
        wrong += tuple(_not_continued(words, folder))
    return ProcessFault(
        seed=seed, command=command, fault=fault, when_s=when_s, exit_code=code, wrong=wrong
    )


def _record(folder: Path) -> None:
    """Make the recording that is verified."""
    words = [*COMMANDS["run"], *ENDS_SOON]
    with CalotProcess(words=words, folder=folder) as process:
        process.end()


def _signalled(number: int, process: CalotProcess, rng: np.random.Generator) -> None:
    with suppress(ProcessLookupError):
        os.kill(process.pid, number)


def _kill_worker(process: CalotProcess, rng: np.random.Generator) -> None:
    if workers := process.workers():
        with suppress(ProcessLookupError):
            os.kill(int(rng.choice(workers)), signal.SIGKILL)


def _fill_disk(process: CalotProcess, rng: np.random.Generator) -> None:
    """Let no file of the command's processes grow, as on a full disk."""
    for pid in process.processes():
        with suppress(ProcessLookupError):
            resource.prlimit(pid, resource.RLIMIT_FSIZE, (NO_ROOM_BYTES, NO_ROOM_BYTES))


def _move_away(process: CalotProcess, rng: np.random.Generator) -> None:
    with suppress(FileNotFoundError):  # nothing has been written yet
        (process.folder / "out").rename(process.folder / "moved")


def _put_file_in_place(process: CalotProcess, rng: np.random.Generator) -> None:
    """Make writing impossible: not even an administrator can write below a file."""
    _move_away(process, rng)
    with suppress(IsADirectoryError):  # the command was faster
        (process.folder / "out").touch()


def _interrupt_twice(process: CalotProcess, rng: np.random.Generator) -> None:
    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGTERM):
        _signalled(number, process, rng)
        time.sleep(0.1)


Interfere = Callable[[CalotProcess, np.random.Generator], None]

FAULTS: dict[str, tuple[Interfere, tuple[int, ...]]] = {
    "kill": (partial(_signalled, signal.SIGKILL), (-signal.SIGKILL,)),
    "kill a worker": (_kill_worker, USUAL),
    "SIGTERM": (partial(_signalled, signal.SIGTERM), (128 + signal.SIGTERM, *USUAL)),
    "SIGINT": (partial(_signalled, signal.SIGINT), (128 + signal.SIGINT, *USUAL)),
    "SIGHUP": (partial(_signalled, signal.SIGHUP), (128 + signal.SIGHUP, *USUAL)),
    "three signals": (_interrupt_twice, (128 + signal.SIGTERM, *USUAL)),
    "full disk": (_fill_disk, (BAD_INPUT, *USUAL)),
    "file in place of the folder": (_put_file_in_place, (BAD_INPUT, *USUAL)),
    "folder vanishes": (_move_away, (BAD_INPUT, *USUAL)),
}
"""By name: what interferes, and the exit codes that are right then."""


def _wrong_exit(code: int, fault: str, err: str) -> Iterator[str]:
    if code not in (right := FAULTS[fault][1] if fault != "none" else USUAL):
        last = (err.strip().splitlines() or [""])[-1]
        yield f"exit code {code}, not one of {right}: {last}"
    if "Traceback" in err:
        yield f"a traceback: {err[err.index('Traceback') :]}"


def _left(process: CalotProcess, grace_s: float) -> Iterator[str]:
    if running := process.left_running(grace_s):
        yield f"processes are still running: {running}"
    if files := list(process.temporary.iterdir()):
        yield f"in the temporary folder: {[file.name for file in files]}"
    out = process.folder / "out"
    try:
        if out.is_dir():
            with claimed(out, "--out"):
                pass
    except BadInputError as error:
        yield f"locked: {error}"


def _lost(folder: Path, *, counted: bool) -> Iterator[str]:
    """Yield damaged files, and finished episodes that are missing in the results."""
    finished = set()
    for file in sorted(folder.rglob("*.npz")):
        try:
            if load(file).result is not None:
                finished.add(file.stem)
        except (OSError, ValueError) as error:
            yield f"damaged: {error}"
    for file in sorted(folder.rglob(RESULTS)):
        seeds = {
            str(episode["seed"]) for episode in json.loads(file.read_text()).get("episodes", ())
        }
        finished -= seeds
    if counted and finished:
        yield f"finished, but in no {RESULTS}: {sorted(finished)}"


def _unanswered(folder: Path) -> Iterator[str]:
    """Yield errors of a command that ends as usual although some episode has no result."""
    files = sorted(folder.rglob(RESULTS))
    numbers = [len(json.loads(file.read_text()).get("episodes", ())) for file in files] or [0]
    for n in numbers:
        if n == 0 or n % EPISODES:
            yield f"ended as usual with {n} results"


def _not_continued(words: Sequence[str], folder: Path) -> Iterator[str]:
    """Yield errors of continuing the evaluation that was killed."""
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*.npz") if load(file).result}
    with CalotProcess(words=words, folder=folder) as process:
        code, _, err = process.end()
    yield from _wrong_exit(code, "none", err)
    again = [file.name for file, time_ns in before.items() if file.stat().st_mtime_ns != time_ns]
    if again:
        yield f"run again, though finished: {again}"
