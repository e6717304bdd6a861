"""`calot evaluate`: suites of conditions, and systems compared on the same patients."""

from __future__ import annotations

import re
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import arg

from planner.learning.files import write_atomic
from scenarios.catalogue import SENSE_OF
from scenarios.commands.cluster_option import require_cluster
from scenarios.commands.folder_options import claimed, require_kernel_cache, require_writable_folder
from scenarios.commands.policy_options import (
    require_cameras,
    require_perception,
    require_policies,
    say_who_acts,
)
from scenarios.commands.typed_options import (
    MOST_SEED,
    MOST_WORKERS,
    at_least,
    number,
    some_arms,
    some_of,
)
from scenarios.evaluation.arm import StudyArm, arm_from_text, require_distinct
from scenarios.files.errors import ERROR, FAILED, INTERRUPTED, BadInputError, refusing
from scenarios.files.outside_text import Terminal, output
from scenarios.files.strict_json import dumps, plain
from scenarios.files.sums import RESULTS, SUMS, read_sums
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.observer import ProgressDisplay
from scenarios.suites import SUITE_NAMES, suite_of
from scenarios.workers.pool import run_each

if TYPE_CHECKING:  # heavy to import
    from scenarios.evaluation.case import Case, Ended
    from scenarios.evaluation.plan import Plan
    from scenarios.evaluation.report import Report
    from scenarios.loop.results import EpisodeResult

DEFAULT = arm_from_text(f"{EpisodeConfig.planner}+{EpisodeConfig.controller}")
UNWRITABLE = "--out: cannot write "
KEPT = "; finished episodes are kept: free some space and run the command again"


@dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Compare arms on the same patients; continue where an earlier call stopped.

    Exit code: 0 done, 1 a pass rate is below --fail-under, 2 bad input or a full disk, 3 errors in
    episodes, 130 interrupted.
    """

    arms: Annotated[tuple[StudyArm, ...], some_arms()] = (DEFAULT,)
    """NAME=PLANNER+CONTROLLER, with ,filter=off ,checkpoint=FILE ,planner-checkpoint=FILE
    ,perception-checkpoint=FILE ,cameras=NAME+NAME ,ablation=no-corrections ,sense=exact
    ,without-rules=NAME+NAME and ,person=surgeon where wanted; the others are compared with the
    first."""
    suite: Annotated[tuple[str, ...], some_of(SUITE_NAMES)] = ("nominal",)
    """Which conditions, names with commas between: of suites, or of scenarios."""
    seed: Annotated[int, at_least(0, MOST_SEED)] = 20_000
    """Seed of the first patient; each further one takes the next. Test seeds start at 20000."""
    episodes: Annotated[int, at_least(1)] = 20
    """Number of patients for each condition."""
    workers: Annotated[int, at_least(1, MOST_WORKERS)] = 1
    """Number of episodes that run in parallel."""
    cluster: Annotated[str | None, arg(metavar="HOST:PORT")] = None
    """Ray cluster that runs them; this machine must be one of its nodes."""
    out: Path = Path("runs/evaluation")
    """Folder of the report and all recordings; what is finished in it is not run again."""
    fail_under: Annotated[float | None, number()] = None
    """Exit with 1 if an arm passes less than this share, 0 to 1, of a suite, ladders left out."""

    def execute(self) -> int:
        """Run the unfinished episodes, and report; return the exit code."""
        self._require_possible()
        with claimed(self.out, "--out"):
            return self._continue()

    def _continue(self) -> int:
        """Run the unfinished episodes, and report; return the exit code."""
        from scenarios.evaluation.folder import finished, open_folder
        from scenarios.evaluation.plan import Plan

        plan = Plan(
            arms=self.arms,
            suites=tuple(suite_of(name) for name in self.suite),
            seeds=range(self.seed, self.seed + self.episodes),
        )
        open_folder(self.out, self.arms)
        results = finished(self.out, plan)
        for arm in self.arms:
            say_who_acts(arm.planner, arm.controller, arm.sense, arm.person, arm.name)
        try:
            self._run(plan, results)
        except KeyboardInterrupt:
            self._report(plan, results)
            return INTERRUPTED
        return self._verdict(self._report(plan, results))

    def _require_possible(self) -> None:
        require_distinct(self.arms)
        require_kernel_cache()
        for arm in self.arms:
            with _named(arm):
                require_cameras(arm.cameras)
                require_policies(
                    arm.planner,
                    arm.controller,
                    arm.checkpoint,
                    arm.planner_checkpoint,
                    arm.cameras,
                )
                require_perception(arm.sense, arm.perception_checkpoint)
            self._require_sense(arm)
        if self.fail_under is not None and not 0.0 <= self.fail_under <= 1.0:
            raise BadInputError(f"--fail-under {self.fail_under:g}: a share is from 0 to 1")
        require_writable_folder(self.out, "--out")
        require_cluster(self.cluster, self.out)

    def _require_sense(self, arm: StudyArm) -> None:
        for name in self.suite:
            for scenario in suite_of(name).scenarios:
                if (needed := SENSE_OF.get(scenario, arm.sense)) != arm.sense:
                    raise BadInputError(
                        f"--suite {name}: {scenario} means nothing by the sense {arm.sense};"
                        f" add ,sense={needed} to the arm {arm.name}"
                    )

    def _run(self, plan: Plan, results: dict[Case, EpisodeResult]) -> None:
        """Run in rounds, because a ladder's next rung waits for the one before."""
        while due := plan.due(results):
            display = ProgressDisplay(len(due), Terminal(stderr=True))
            with display, closing(self._ended(due, display)) as arriving:
                for case, tried in arriving:
                    if tried.unwritable is not None:
                        raise BadInputError(f"{UNWRITABLE}{tried.unwritable}{KEPT}")
                    results[case] = tried.result
                    if tried.result.error is None:  # else the episode will run again
                        self._note(case)
                    display.advance()

    def _note(self, case: Case) -> None:
        from scenarios.evaluation.folder import note

        with refusing(OSError, before=f"{UNWRITABLE}{self.out / SUMS} (", after=f"){KEPT}"):
            note(self.out, case)

    def _ended(self, due: Sequence[Case], display: ProgressDisplay) -> Generator[Ended, None, None]:
        from scenarios.evaluation.case import after_death, attempt

        outside = any(case.config.outside for case in due)  # it may end its process
        here = None if outside else partial(attempt, out=self.out, observers=[display])
        apart = partial(attempt, out=self.out)
        return run_each(apart, due, self.workers, after_death, self.cluster, here)

    def _report(self, plan: Plan, results: Mapping[Case, EpisodeResult]) -> Report:
        """Write the report and show it."""
        from scenarios.evaluation.folder import open_folder
        from scenarios.evaluation.page import page
        from scenarios.evaluation.report import document, report_of
        from scenarios.evaluation.tables import tables

        open_folder(self.out, self.arms)  # the folder may have vanished
        report, made_with = report_of(plan, results, self.out), self._made_with()
        told = {**document(report, made_with), "recordings": read_sums(self.out)}
        self._write(RESULTS, dumps(told, indent=2) + "\n")
        self._write("report.html", page(report, made_with))
        console = output()
        for table in tables(report).values():
            if table.rows and not table.page_only:
                console.print(table.drawn())
        for name in (RESULTS, "report.html"):
            console.print(f"{self.out / name}", soft_wrap=True)
        return report

    def _made_with(self) -> dict[str, Any]:
        """Return the options that determine the results: not the folder, workers or limit."""
        from scenarios.files.versions import source_digest, versions

        defaults = replace(
            self, out=Evaluate.out, workers=Evaluate.workers, cluster=None, fail_under=None
        )
        return {"config": plain(defaults), "versions": {"source": source_digest()} | versions()}

    def _write(self, name: str, text: str) -> None:
        with refusing(OSError, before=f"{UNWRITABLE}{self.out / name} (", after=f"){KEPT}"):
            write_atomic(self.out / name, text.encode())

    def _verdict(self, report: Report) -> int:
        from scenarios.evaluation.report import lowest_pass_rate

        if any(arm.errors for arm in report.arms.values()):
            return ERROR
        lowest = lowest_pass_rate(report)
        if self.fail_under is None or lowest is None or lowest[0] >= self.fail_under:
            return 0
        rate, arm, suite = lowest
        line = f"{arm} passes {rate:.3f} of {suite}, less than --fail-under {self.fail_under:g}"
        Terminal().print(line, soft_wrap=True)
        return FAILED


@contextmanager
def _named(arm: StudyArm) -> Iterator[None]:
    """Name the system in error messages, and its options in the form that systems have."""
    try:
        yield
    except BadInputError as error:
        said = re.sub(r"--sense (\w+)", r",sense=\1", str(error))
        said = re.sub(r"--((?:\w+-)?checkpoint|cameras)\b", r",\1=", said)
        said = re.sub(r"--(planner|controller) ", r"\1 ", said)
        raise BadInputError(f"--arms {arm.name}: {said}") from None
