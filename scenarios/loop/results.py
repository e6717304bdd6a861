"""The result of an episode, the pass rate of several with its interval, and results.json."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from controller.safety.ledger import Entry
from planner.learning.files import write_atomic
from planner.rules.rule_use import RuleUse
from scenarios.files.strict_json import dumps
from scenarios.files.sums import digest_of
from scenarios.files.versions import versions
from tissue_sim.patient.tube_names import USUAL_TUBES

Outcome = Literal["passed", "failed", "called", "error"]


@dataclass(frozen=True, kw_only=True)
class TaskResult:
    """The result of one of the procedure's tasks.

    Attributes:
        corrections: Number of corrective instructions during the task.
        path_m: Path lengths of the left and the right tip in the endoscope's frame; None if an
            older version wrote the result.
        jerk_m_s3: Mean magnitude of either tip's jerk, from third differences of its position
            between control steps; None if there were too few.
        failure_chance: The planner's highest chance of failure; None if the planner gives none.
        alarm_s: Simulated time of the planner's first alarm in the task; None without one.
        left_out: Passed over by the rule for fewer clips (`tissue_sim.outcome.room`): no success,
            and no failure.
    """

    index: int
    instruction: str
    success: bool
    time_s: float
    corrections: int
    path_m: tuple[float, float] | None = None
    jerk_m_s3: tuple[float, float] | None = None
    failure_chance: float | None = None
    alarm_s: float | None = None
    left_out: bool = False

    @property
    def is_over(self) -> bool:
        """Return whether nothing of the task is left to do."""
        return self.success or self.left_out


@dataclass(frozen=True, kw_only=True)
class InjuryResult:
    """An injury of the patient; value and limit in the event's own SI unit."""

    event: str
    time_s: float
    value: float
    limit: float


@dataclass(frozen=True, kw_only=True)
class PeakResult:
    """The value of a limited quantity that came nearest to its limit, or went furthest beyond it.

    Attributes:
        event: The injury that the value becomes beyond the limit, or a measure of the clips in
            place.
        at_least: Whether the limit is a lower one.
    """

    event: str
    value: float
    limit: float
    at_least: bool = False

    def breaks(self, factor: float) -> bool:
        """Tell whether the value breaks the limit times a factor."""
        limit = factor * self.limit
        return self.value < limit if self.at_least else self.value > limit


@dataclass(frozen=True, kw_only=True)
class SafetyResult:
    """The safety filter's interventions in an episode.

    Attributes:
        filter: Whether the episode had a filter.
        interventions: Number of entries of the ledger.
        min_clearance_m: Smallest distance of an instrument to a keep-out; None if nothing was
            near, or the distance was not measured.
        ledger: Every event in which commands were altered, and the reason.
    """

    filter: bool = True
    interventions: int = 0
    min_clearance_m: float | None = None
    ledger: tuple[Entry, ...] = ()


@dataclass(frozen=True, kw_only=True)
class SensingResult:
    """Errors of the observations against the truth, over an episode.

    Attributes:
        near_m, near_p90_m: Median and 90th percentile of the errors of the tubes' points within 15
            mm of the right tip; None if the tip never came so near.
        from_tip_m: The same median, relative to the estimated tip: the error of an arm that acts by
            this estimate. None if an older version wrote the result.
        clips_m: Median error of the clips; None if there was none.
        clips_counted: Share of moments in which the number of clips is right.
        cuts_seen: Share of moments in which the observed cuts of the tubes are right.
        within_95: Share of these points that lie in their 95 % ellipsoid.
        hidden: Share of the tubes' points that no camera shows.
        over_time_m: The median error near the right tip in each 5 s of the episode; None where the
            tip did not come so near.
    """

    near_m: float | None
    near_p90_m: float | None
    from_tip_m: float | None = None
    clips_m: float | None
    clips_counted: float
    cuts_seen: float
    within_95: float | None
    hidden: float
    over_time_m: tuple[float | None, ...] = ()


@dataclass(frozen=True, kw_only=True)
class ActResult:
    """The controller's answer that took longest for the motions in it.

    Attributes:
        took_s: Wall time.
        lasts_s: Simulated time of its motions; a robot would have to wait for longer answers.
    """

    took_s: float
    lasts_s: float

    @property
    def share(self) -> float:
        """Return the wall time of the answer over the duration of its motions."""
        return self.took_s / self.lasts_s


@dataclass(frozen=True, kw_only=True)
class CallResult:
    """The planner's call for a person, with which the episode ended.

    Attributes:
        reason: In the planner's words.
        in_time: Nothing irreversible had been done; an episode that called later has failed.
        needed: The anatomy makes the procedure impossible, see `tissue_sim.outcome.room`.
    """

    reason: str
    in_time: bool
    needed: bool

    @property
    def in_words(self) -> str:
        """Return the reason, and whether the call was right."""
        manner = "too late" if not self.in_time else "rightly" if self.needed else "without need"
        return f"called {manner}: {self.reason}"


@dataclass(frozen=True, kw_only=True)
class EpisodeResult:
    """The result of one episode.

    Attributes:
        success: All tasks done, clips holding, no leak, no injury; False when called or in error.
        call: The planner's call for a person; None if the planner made none.
        error: The error that broke the episode off, which is not a failure of the surgeon; None for
            none.
        procedure_time_s: Simulated time without exchanges.
        exchange_time_s: Simulated time of tool exchanges and clip reloads.
        wall_s: Wall time.
        corrections: Sum over the tasks.
        dropped_clips: Clips that closed on nothing or fell from the applier; more than
            `CLIPS_LEFT_MAX` of them are an injury.
        peaks: How near each limited quantity came to its limit; empty if an older version wrote the
            result.
        anatomy_hash: Identifies the anatomy; None if the episode broke off before it was made.
        tubes: The patient's tubes, by their names in the endoscope's view.
        sense: The sense of planner, controller and filter, a key of `catalogue.SENSES`.
        sensing: Errors of the observations; None for the exact state, or if the episode broke off.
        privileged: Which of "planner" and "controller" also read the hidden state.
        rules: The changes of hand-written rules to the networks' decisions, by rule; empty for
            policies without a network, or without rules.
        procedure: A key of `catalogue.PROCEDURES`, or MODULE:PROCEDURE.
        act: The controller's slowest answer, by wall time like `wall_s`. None if an older version
            wrote the result, or the episode broke off.
    """

    scenario: str
    seed: int
    planner: str
    controller: str
    success: bool
    call: CallResult | None = None
    error: str | None = None
    tasks: tuple[TaskResult, ...] = ()
    procedure_time_s: float = 0.0
    exchange_time_s: float = 0.0
    wall_s: float = 0.0
    corrections: int = 0
    dropped_clips: int = 0
    injuries: tuple[InjuryResult, ...] = ()
    peaks: tuple[PeakResult, ...] = ()
    safety: SafetyResult = SafetyResult()
    anatomy_hash: str | None = None
    tubes: tuple[str, ...] = USUAL_TUBES
    sense: str = "exact"
    sensing: SensingResult | None = None
    privileged: tuple[str, ...] = ()
    act: ActResult | None = None
    rules: tuple[RuleUse, ...] = ()
    procedure: str = "cholecystectomy"

    @property
    def outcome(self) -> Outcome:
        """Return how the episode ended; "called" means in time, whether or not it was needed."""
        if self.error is not None:
            return "error"
        if self.call is not None and self.call.in_time:
            return "called"
        return "passed" if self.success else "failed"

    @property
    def is_judged(self) -> bool:
        """Return whether the procedure was done or tried, and so passed or failed."""
        return self.outcome in ("passed", "failed")

    @property
    def is_needless_call(self) -> bool:
        """Return whether a person was called, although the procedure could have been done."""
        return self.outcome == "called" and self.call is not None and not self.call.needed

    @property
    def is_counted(self) -> bool:
        """Return whether the episode counts in a pass rate: no error, and not rightly called."""
        return self.is_judged or self.is_needless_call


@dataclass(frozen=True, kw_only=True)
class Summary:
    """The ends of episodes, and the pass rate.

    A call without need counts as not passed, so that no planner raises its rate by declining.
    Episodes that were called rightly, or ended in an error, do not count in the rate.

    Attributes:
        called: Number in which the planner called for a person in time.
        needless: Number of these in which the procedure could have been done.
        pass_rate: None if no episode counts.
        wilson_95: Interval of the pass rate.
    """

    episodes: int
    passed: int
    called: int
    needless: int
    errors: int
    pass_rate: float | None
    wilson_95: tuple[float, float]

    @property
    def counted(self) -> int:
        """Return the number of episodes that count in the pass rate."""
        return self.episodes - self.rightly_called - self.errors

    @property
    def rightly_called(self) -> int:
        """Return the number of timely calls for patients on whom the procedure is impossible."""
        return self.called - self.needless


def summarise(episodes: Sequence[EpisodeResult]) -> Summary:
    """Summarise episodes."""
    outcomes = Counter(episode.outcome for episode in episodes)
    passed, counted = outcomes["passed"], sum(episode.is_counted for episode in episodes)
    return Summary(
        episodes=len(episodes),
        passed=passed,
        called=outcomes["called"],
        needless=sum(episode.is_needless_call for episode in episodes),
        errors=outcomes["error"],
        pass_rate=passed / counted if counted else None,
        wilson_95=wilson_interval(passed, counted),
    )


def write_results(path: Path, episodes: Sequence[EpisodeResult], config: Mapping[str, Any]) -> None:
    """Write the whole results.json; call it after each episode, so that no result is lost."""
    recordings = {}
    for name in (f"episodes/{episode.seed}.npz" for episode in episodes):
        with suppress(FileNotFoundError):
            recordings[name] = digest_of(path.parent / name)
    document = {
        "episodes": episodes,
        "summary": summarise(episodes),
        "recordings": recordings,
        "config": config,
        "versions": versions(),
    }
    write_atomic(path, (dumps(document, indent=2) + "\n").encode())


def wilson_interval(passed: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Return the score interval of Wilson (1927, J. Am. Stat. Assoc. 22:209-212, eq. 2).

    Its ends are the two rates p that solve (passed/n - p)^2 = z^2 p (1 - p) / n.

    Args:
        passed: Number of successes, 0 to n.
        n: Number of trials; for 0 the interval is (0, 1).
        z: Normal quantile; 1.96 for 95 %.

    Raises:
        ValueError: `passed` is not within 0 and n.
    """
    if not 0 <= passed <= n:
        raise ValueError(f"passed must be 0 to n = {n}, got {passed}")
    if n == 0:
        return 0.0, 1.0
    rate, z2 = passed / n, z * z
    centre = rate + z2 / (2 * n)
    half_width = z * math.sqrt(rate * (1 - rate) / n + z2 / (4 * n * n))
    scale = 1 + z2 / n
    return max(0.0, (centre - half_width) / scale), min(1.0, (centre + half_width) / scale)
