"""`calot run`: autonomous episodes, judged."""

from __future__ import annotations

import os
from collections.abc import Generator, Iterator, Sequence
from contextlib import ExitStack, closing
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import arg

from scenarios.catalogue import PEOPLE, procedure_named
from scenarios.commands.browser import LOCAL, new_session, page_of
from scenarios.commands.cluster_option import require_cluster
from scenarios.commands.episode_options import EpisodeOptions
from scenarios.commands.folder_options import (
    claimed,
    require_writable_file,
    require_writable_folder,
)
from scenarios.commands.policy_options import require_renderer, say_who_acts
from scenarios.commands.typed_options import MOST_WORKERS, at_least, one_of, text_of
from scenarios.demonstration.alike import require_joinable
from scenarios.demonstration.mix import TRAINING_SEEDS
from scenarios.files.errors import ERROR, FAILED, INTERRUPTED, BadInputError, refusing
from scenarios.files.outside_text import Terminal, output
from scenarios.files.strict_json import plain
from scenarios.files.sums import MANIFEST, RESULTS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import Observer, ProgressDisplay
from scenarios.loop.person.script import Timed, read_script
from scenarios.loop.results import EpisodeResult, summarise, write_results
from scenarios.recording.attempt import Attempt, attempt_episode, lost, trace_path
from scenarios.recording.result_tables import (
    act_lines,
    call_lines,
    episode_table,
    error_lines,
    injury_table,
    ledger_table,
    rule_table,
    sensing_lines,
    summary_line,
    task_table,
)
from scenarios.recording.video import VideoWriter
from scenarios.workers.pool import run_each

if TYPE_CHECKING:
    from scenarios.demonstration.interventions import Interventions
    from scenarios.viewer.session_state import SessionState

VIDEO_SUFFIX = ".mp4"
UNWRITABLE = "--out: cannot write "
KEPT = "; finished episodes are kept: free some space and run the others with another --out"


@dataclass(frozen=True, kw_only=True)
class Run(EpisodeOptions):
    """Run one or more autonomous episodes.

    Exit code: 0 all passed or rightly called for a person, 1 some failed or called without need.
    Exit code 2: bad input or a full disk; 3: some ended in error; 130: interrupted.
    """

    instruct: Annotated[Path | None, arg(metavar="FILE")] = None
    """What a person says and when; each line is SECONDS of simulated time, a tab, the words."""
    person: Annotated[str | None, one_of(PEOPLE)] = None
    """A scripted person who sees the truth, and corrects the robot in words."""
    save_interventions: Annotated[Path | None, arg(metavar="FOLDER")] = None
    """Dataset that gains each episode in which somebody was obeyed; on training seeds only."""
    episodes: Annotated[int, at_least(1)] = 1
    """Number of episodes."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of episodes that run in parallel."""
    cluster: Annotated[str | None, arg(metavar="HOST:PORT")] = None
    """Ray cluster that runs them; this machine must be one of its nodes."""
    view: bool = False
    """Whether it is shown in the browser, where people may correct it; one worker only."""
    out: Path = Path("runs/latest")
    """Folder for results.json, which is replaced, and the recorded episodes."""
    video: Annotated[Path | None, arg(metavar="FILE.mp4")] = None
    """File for the endoscope's view; needs a renderer and a single episode."""
    overlay: bool = False
    """Draw what the robot sees on the video: points, their 95 % ellipses, hidden ones in orange."""
    captions: bool = False
    """Write below the video what is said and why, what happens, and at last the result."""

    def execute(self) -> int:
        """Run, keep each finished episode in results.json, and report; return the exit code."""
        self._require_possible()
        with ExitStack() as claims:
            for folder, option in self._folders():
                claims.enter_context(claimed(folder, option))
            return self._run_and_report()

    def _folders(self) -> Iterator[tuple[Path, str]]:
        """Yield each folder that is written to, and its option."""
        yield self.out, "--out"
        datasets = self.save_interventions
        if datasets is not None and os.path.realpath(datasets) != os.path.realpath(self.out):
            yield datasets, "--save-interventions"

    def _run_and_report(self) -> int:
        say_who_acts(self.planner, self.controller, self.sense_in_force, self.person)
        finished: list[EpisodeResult] = []
        self._write(finished)
        try:
            self._run(finished)
        except KeyboardInterrupt:
            self._report(finished)
            _say(output(), f"interrupted after {len(finished)} of {self.episodes} episodes")
            return INTERRUPTED
        except BadInputError:
            if finished:  # the disk became full after some finished episodes
                self._report(finished)
            raise
        self._report(finished)
        return exit_code(finished)

    def _require_possible(self) -> None:
        self.require_episode()
        if self.view:
            self._require_alone("--view")
        if self.instruct is not None:
            read_script(self.instruct)
        if self.video is not None:
            self._require_video_possible(self.video)
        elif self.overlay or self.captions:
            option = "--overlay" if self.overlay else "--captions"
            raise BadInputError(f"{option} needs --video FILE{VIDEO_SUFFIX}, on which it is drawn")
        if self.save_interventions is not None:
            self._require_savable(self.save_interventions)
        require_writable_folder(self.out, "--out")
        if (self.out / MANIFEST).exists():
            raise BadInputError(
                f"--out {self.out}: it has a report of `calot evaluate`; name another folder"
            )
        require_cluster(self.cluster, self.out)

    def _require_alone(self, option: str) -> None:
        if self.workers > 1 or self.cluster is not None:
            given = f"--cluster {self.cluster}" if self.cluster else f"--workers {self.workers}"
            raise BadInputError(f"{option} needs --workers 1 and no --cluster, got {given}")

    def _require_savable(self, folder: Path) -> None:
        self._require_alone("--save-interventions")
        if self.seed + self.episodes > TRAINING_SEEDS.stop:
            raise BadInputError(
                f"--save-interventions takes training seeds only, 0 to {TRAINING_SEEDS.stop - 1}:"
                f" got --seed {self.seed} --episodes {self.episodes}"
            )
        require_writable_folder(folder, "--save-interventions")
        require_joinable(folder, self.sense_in_force)

    def _require_video_possible(self, video: Path) -> None:
        if video.suffix != VIDEO_SUFFIX:
            raise BadInputError(f"--video {video}: the file must end in {VIDEO_SUFFIX}")
        self._require_alone("--video")
        if self.episodes != 1:
            raise BadInputError(f"--video needs --episodes 1, got {self.episodes}")
        require_renderer("--video")
        require_writable_file(video, "--video")

    def _run(self, finished: list[EpisodeResult]) -> None:
        with ExitStack() as stack:
            session = self._session() if self.view else None
            if session is not None:
                stack.enter_context(page_of(session, LOCAL, None))
            procedure = procedure_named(self.procedure)
            display = stack.enter_context(
                ProgressDisplay(self.episodes, Terminal(stderr=True), procedure)
            )
            observers: list[Observer] = [display]
            if self.video is not None:
                video = VideoWriter(path=self.video, overlay=self.overlay, captions=self.captions)
                observers.append(stack.enter_context(video))
            interventions = self._interventions()
            observers += [] if interventions is None else [interventions]
            attempts = stack.enter_context(closing(self._attempts(observers, session)))
            for attempt in attempts:
                if attempt.unwritable is not None:
                    raise BadInputError(f"{UNWRITABLE}{attempt.unwritable}{KEPT}")
                finished.append(attempt.result)
                finished.sort(key=lambda episode: episode.seed)
                self._write(finished)
                display.advance()
                if interventions is not None and interventions.unsaved:
                    raise BadInputError(
                        f"--save-interventions: cannot save that of seed {attempt.result.seed}:"
                        f" {interventions.unsaved}; finished episodes are kept"
                    )

    def _interventions(self) -> Interventions | None:
        if self.save_interventions is None:
            return None
        from scenarios.demonstration.interventions import Interventions

        return Interventions(self.save_interventions, next(self._configs()))

    def _configs(self) -> Iterator[EpisodeConfig]:
        """Yield the configuration of each episode; there may be many."""
        first = replace(self.first_config(), instruct=text_of(self.instruct), person=self.person)
        return (replace(first, seed=self.seed + k) for k in range(self.episodes))

    def _session(self) -> SessionState:
        return new_session(
            next(self._configs()), self.out, paused=False, restarts=False, camera=False
        )

    def _attempts(
        self, observers: Sequence[Observer], session: SessionState | None
    ) -> Generator[Attempt, None, None]:
        alone = bool(session or self.video or self.save_interventions)  # they watch each step
        outside = bool(self.first_config().outside) and not alone

        def here(config: EpisodeConfig) -> Attempt:
            if session is None:
                return attempt_episode(config, self.out, observers)
            session.begin(config)
            watching = (*observers, session.interventions, session.watcher)
            return attempt_episode(config, self.out, watching, session.inbox)

        apart = partial(attempt_episode, out=self.out)
        return run_each(
            apart, self._configs(), self.workers, lost, self.cluster, None if outside else here
        )

    def _report(self, episodes: Sequence[EpisodeResult]) -> None:
        console = output()
        if len(episodes) == 1:
            console.print(task_table(episodes[0]))
            if episodes[0].injuries:
                console.print(injury_table(episodes[0]))
            if episodes[0].safety.ledger:
                console.print(ledger_table(episodes[0]))
        elif episodes:
            console.print(episode_table(episodes))
        if (rules := rule_table(episodes)) is not None:
            console.print(rules)
        script = () if self.instruct is None else read_script(self.instruct)
        for line in (
            *call_lines(episodes),
            *error_lines(episodes),
            *_trace_lines(episodes, self.out),
            *unsaid_lines(episodes, script),
            *(sensing_lines(episodes) if len(episodes) == 1 else ()),
            *act_lines(episodes),
            summary_line(summarise(episodes)),
            f"results: {self.out / RESULTS}",
        ):
            _say(console, line)

    def _write(self, finished: Sequence[EpisodeResult]) -> None:
        path = self.out / RESULTS
        with refusing(OSError, before=f"{UNWRITABLE}{path}: ", after=KEPT):
            write_results(path, finished, config=plain(self))


def exit_code(episodes: Sequence[EpisodeResult]) -> int:
    """Return 3 after any error, else 1 after any failure or call without need, else 0."""
    summary = summarise(episodes)
    if summary.errors:
        return ERROR
    return 0 if summary.passed == summary.counted else FAILED


def _trace_lines(episodes: Sequence[EpisodeResult], out: Path) -> list[str]:
    traces = (trace_path(out, str(episode.seed)) for episode in episodes if episode.error)
    return [f"traceback: {trace}" for trace in traces if trace.exists()]


def unsaid_lines(episodes: Sequence[EpisodeResult], script: Sequence[Timed]) -> Iterator[str]:
    """Yield a line for each completed episode that ended before all its script was said."""
    for episode in (episode for episode in episodes if episode.error is None):
        end_s = episode.procedure_time_s + episode.exchange_time_s
        if unsaid := sum(timed.time_s > end_s for timed in script):
            yield (
                f"seed {episode.seed} ended at {end_s:.1f} s: {unsaid} of {len(script)} lines of"
                " --instruct were not said"
            )


def _say(console: Terminal, line: str) -> None:
    console.print(line, soft_wrap=True)
