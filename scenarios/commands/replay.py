"""`calot replay`: run a recorded episode again: check it, show it, or export it as a page."""

from __future__ import annotations

import os
from collections.abc import Generator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event
from typing import TYPE_CHECKING, Annotated

from rich.progress import track
from tyro.conf import Positional, arg

from scenarios.commands.browser import LOCAL
from scenarios.commands.folder_options import require_kernel_cache, require_writable_file
from scenarios.commands.typed_options import MOST_WORKERS, at_least
from scenarios.files.errors import FAILED, INTERRUPTED, BadInputError, refusing
from scenarios.files.outside_text import Terminal, output
from scenarios.recording.verify import (
    EXIT_CODES,
    Verdict,
    lost,
    recordings_in,
    verdict_table,
    verify,
)
from scenarios.workers.pool import run_each

if TYPE_CHECKING:
    from scenarios.viewer.recording_frames import RecordingFrames

VIEW_EVERY = 3  # steps a frame: 10 a second


@dataclass(frozen=True, kw_only=True)
class Replay:
    """Run a recorded episode again, and say whether it is identical.

    The recorded commands go through the world; with --verify, planner, controller and filter decide
    again. Exit code: 0 identical to the bit; 1 different; 2 bad input or a refused file; 3 a worker
    died. Exit code 130: interrupted before the end, identical so far. Of several files, the largest
    code counts.
    """

    files: Annotated[Positional[tuple[Path, ...]], arg(metavar="FILE")]
    """A recorded episode, `episodes/SEED.npz`; with --verify, several of them or folders."""
    verify: bool = False
    """Run the whole episode again from its seed, and compare everything that was recorded."""
    planner: Annotated[str | None, arg(metavar="MODULE:FACTORY")] = None
    """Your own planner, which --verify may run where a recording names it."""
    controller: Annotated[str | None, arg(metavar="MODULE:FACTORY")] = None
    """Your own controller, likewise."""
    sense: Annotated[str | None, arg(metavar="MODULE:FACTORY")] = None
    """Your own sense, likewise."""
    procedure: Annotated[str | None, arg(metavar="MODULE:PROCEDURE")] = None
    """Your own procedure, which replay may import where a recording names it."""
    trust: bool = False
    """Let --verify run whatever code a recording names: only for recordings of your own."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """How many episodes are verified in parallel."""
    beside: Annotated[Path | None, arg(metavar="FILE")] = None
    """A second recorded episode, shown beside the first."""
    view: bool = False
    """Show the episode in the browser, with a timeline, until Ctrl-C."""
    export: Annotated[Path | None, arg(metavar="PAGE.html")] = None
    """Write an HTML page that needs no server."""
    host: Annotated[str, arg(metavar="ADDRESS")] = LOCAL
    """Address to listen on with --view."""
    port: Annotated[int | None, at_least(1)] = None
    """Port to listen on with --view; the default is the first free one from 8080 on."""

    def execute(self) -> int:
        """Replay; return the exit code."""
        self._require_possible()
        if self.verify:
            return self._verify()
        if self.view:
            return self._show()
        return self._export(self.export) if self.export is not None else self._check()

    def _require_possible(self) -> None:
        if self.verify and (self.view or self.export or self.beside):
            raise BadInputError("--verify cannot be combined with --view, --export or --beside")
        if not self.verify and (self.planner or self.controller or self.sense or self.trust):
            raise BadInputError("--planner, --controller, --sense and --trust need --verify")
        if not self.verify and len(self.files) != 1:
            raise BadInputError(
                f"give one FILE, got {len(self.files)}; only --verify takes several"
            )
        if self.view and self.export:
            raise BadInputError("--view cannot be combined with --export")
        if self.export is not None:
            require_writable_file(self.export, "--export")
        if self.beside is not None and not self.view:
            raise BadInputError("--beside needs --view")
        require_kernel_cache()

    def _verify(self) -> int:
        files = self._recordings()
        console = Terminal(stderr=True)
        with closing(self._verdicts(files)) as arriving:
            shown = track(
                arriving,
                "verifying",
                total=len(files),
                console=console,
                transient=True,
                disable=not console.is_terminal,
            )
            verdicts = sorted(shown, key=lambda verdict: verdict.file)
        if len(verdicts) == 1 and verdicts[0].outcome == "refused":
            raise BadInputError(verdicts[0].remark)
        _tell(verdicts)
        return max(EXIT_CODES[verdict.outcome] for verdict in verdicts)

    def _recordings(self) -> list[Path]:
        files = []
        for path in self.files:
            if not os.path.exists(path):
                raise BadInputError(f"{path}: No such file or directory")
            if not (found := recordings_in(path)):
                raise BadInputError(f"{path}: no recordings (*.npz) in it")
            files += found
        if not files:
            raise BadInputError("--verify needs a FILE or a folder")
        return files

    def _verdicts(self, files: Sequence[Path]) -> Generator[Verdict, None, None]:
        named = (self.planner, self.controller, self.sense, self.procedure)
        check = partial(verify, allowed=None if self.trust else frozenset(filter(None, named)))
        return run_each(check, files, self.workers, lost, here=check)

    def _check(self) -> int:
        recording = self._frames_of(self.files[0], every=1_000_000)
        with Terminal(stderr=True).status("replaying"):
            for _ in recording.run():
                pass
        return _verdict(recording)

    def _export(self, page: Path) -> int:
        from planner.learning.files import write_atomic
        from scenarios.viewer.replay_page import EXPORT_EVERY, export

        recording = self._frames_of(self.files[0], every=EXPORT_EVERY)
        with Terminal(stderr=True).status("drawing") as status:
            html = export(recording, lambda time_s: status.update(f"drawing: {time_s:.0f} s"))
        with refusing(OSError, before=f"--export: cannot write {page} (", after=")"):
            write_atomic(page, html.encode())
        Terminal().print(f"{page}: {page.stat().st_size / 1e6:.1f} MB")
        return _verdict(recording)

    def _show(self) -> int:
        files = [*self.files, *([self.beside] if self.beside else [])]
        recordings = [self._frames_of(file, every=VIEW_EVERY) for file in files]
        from scenarios.viewer.replay_page import ReplayPage
        from scenarios.viewer.serving.open_page import serve

        names = [file.stem for file in files]
        with (
            serve(
                lambda port: ReplayPage(recordings, names, host=self.host, port=port),
                self.host,
                self.port,
            ),
            suppress(KeyboardInterrupt),
        ):
            for recording in recordings:
                for _ in recording.run():
                    pass
            Event().wait()
        heads = [f"{file}: " if self.beside else "" for file in files]
        codes = [_verdict(*pair) for pair in zip(recordings, heads, strict=True)]
        return FAILED if FAILED in codes else max(codes)

    def _frames_of(self, file: Path, *, every: int) -> RecordingFrames:
        from scenarios.recording.recorder import load
        from scenarios.viewer.recording_frames import RecordingFrames

        with refusing(ValueError), refusing(OSError, before=f"{file}: "):
            recording = load(file)
        if not len(recording.arrays["time_s"]):
            why = f"broke off before its first step: {recording.error}"
            raise BadInputError(f"{file}: it {why if recording.error else 'has no step'}")
        with refusing(ValueError, before=f"{file}: "):
            return RecordingFrames(
                recording, every=every, allowed=frozenset(filter(None, [self.procedure]))
            )


def _tell(verdicts: Sequence[Verdict]) -> None:
    console = output()
    if len(verdicts) == 1:
        line = f"{verdicts[0].outcome}, {verdicts[0].remark}"
    else:
        console.print(verdict_table(verdicts))
        same = sum(verdict.outcome == "identical" for verdict in verdicts)
        line = f"{same} of {len(verdicts)} identical"
    console.print(line, soft_wrap=True)


def _verdict(recording: RecordingFrames, head: str = "") -> int:
    """Print whether the replay is identical, after `head`; return the exit code."""
    line, code = _identical(recording), 0
    if recording.differs_s is not None:
        what = ", ".join(recording.differs_in)
        line, code = f"different from {recording.differs_s:.1f} s on: {what}", FAILED
    elif not recording.is_replayed:
        done, code = f"{recording.replayed_s:.1f} s of {recording.end_s:.1f} s", INTERRUPTED
        line = f"interrupted at {done}, identical so far"
    Terminal().print(head + line, soft_wrap=True)
    return code


def _identical(recording: RecordingFrames) -> str:
    judged = ", and how the patient is judged" if recording.has_result else ""
    return (
        f"identical to the bit: time, joints, tip poses, forces, tools and injuries of"
        f" {recording.n_replayed:,} steps{judged}; not compared: what the policies decided"
        " (--verify compares it)"
    )
