"""Results as tables for people to read."""

from collections.abc import Sequence

from rich.table import Table

from planner.rules.rule_use import total
from scenarios.files.outside_text import table_of
from scenarios.loop.results import EpisodeResult, Summary


def task_table(episode: EpisodeResult) -> Table:
    """Return a table with one row for each task."""
    rows = (
        (
            str(task.index),
            task.instruction,
            "left out" if task.left_out else "yes" if task.success else "no",
            f"{task.time_s:.1f}",
            str(task.corrections),
        )
        for task in episode.tasks
    )
    title = f"seed {episode.seed}: {episode.outcome}"
    return table_of(title, ("task", "instruction", "done"), ("time (s)", "corrections"), rows)


def injury_table(episode: EpisodeResult) -> Table:
    """Return a table with one row for each injury."""
    rows = (
        (injury.event, f"{injury.time_s:.1f}", f"{injury.value:.4g}", f"{injury.limit:.4g}")
        for injury in episode.injuries
    )
    return table_of("injuries", ("event",), ("time (s)", "value", "limit"), rows)


def ledger_table(episode: EpisodeResult) -> Table:
    """Return a table with one row for each event in which the safety filter changed commands."""
    rows = (
        (e.words, str(e.commands), f"{e.time_s:.1f}", f"{e.end_s:.1f}")
        for e in episode.safety.ledger
    )
    return table_of("safety filter", ("what it did",), ("commands", "from (s)", "to (s)"), rows)


def rule_table(episodes: Sequence[EpisodeResult]) -> Table | None:
    """Return a table of the rules that overruled a network; None if none did."""
    uses = total(use for episode in episodes for use in episode.rules)
    rows = [
        (
            f"{use.policy}: {use.rule}",
            str(use.decisions),
            str(use.changed),
            f"{use.share:.0%}",
            _mm(use.most_m),
            "-" if use.most_rad is None else f"{use.most_rad:.2f} rad",
        )
        for use in uses
        if use.changed
    ]
    title = "rules that changed what a network decided (docs/rules.md)"
    figures = ("decisions", "changed", "share", "tip at most", "jaw at most")
    return table_of(title, ("rule",), figures, rows) if rows else None


def sensing_lines(episodes: Sequence[EpisodeResult]) -> list[str]:
    """Return a line with the sensing errors of each episode whose observations had errors."""
    return [
        f"sensed ({e.sense}), seed {e.seed}: points near the right tip {_mm(e.sensing.near_m)}"
        f" (median), {_mm(e.sensing.near_p90_m)} (90 %), clips {_mm(e.sensing.clips_m)};"
        f" clips counted right {e.sensing.clips_counted:.1%}, cuts {e.sensing.cuts_seen:.1%}"
        for e in episodes
        if e.sensing is not None
    ]


def _mm(length_m: float | None) -> str:
    return "-" if length_m is None else f"{1e3 * length_m:.2f} mm"


def episode_table(episodes: Sequence[EpisodeResult]) -> Table:
    """Return a table with one row for each episode."""
    rows = (
        (
            str(episode.seed),
            episode.outcome,
            str(sum(task.success for task in episode.tasks)),
            f"{episode.procedure_time_s:.1f}",
            str(episode.corrections),
            str(len(episode.injuries)),
            str(episode.safety.interventions),
            f"{episode.wall_s:.1f}",
        )
        for episode in episodes
    )
    figures = ("tasks", "simulated (s)", "corrections", "injuries", "altered", "wall (s)")
    return table_of("episodes", ("seed", "outcome"), figures, rows)


def act_lines(episodes: Sequence[EpisodeResult]) -> list[str]:
    """Return a line for each controller that was slower than its motions, or for the only one."""
    return [
        f"seed {e.seed}: the controller took at most {e.act.took_s:.3f} s for motions that last"
        f" {e.act.lasts_s:.3f} s" + (": too slow for a robot" if e.act.share > 1.0 else "")
        for e in episodes
        if e.act is not None and (e.act.share > 1.0 or len(episodes) == 1)
    ]


def error_lines(episodes: Sequence[EpisodeResult]) -> list[str]:
    """Return one line for each episode that ended in error."""
    return [
        f"seed {episode.seed} ended in error: {episode.error}"
        for episode in episodes
        if episode.error is not None
    ]


def call_lines(episodes: Sequence[EpisodeResult]) -> list[str]:
    """Return one line for each episode in which the planner called for a person."""
    return [
        f"seed {episode.seed} {episode.call.in_words}"
        for episode in episodes
        if episode.call is not None
    ]


def summary_line(summary: Summary) -> str:
    """Return the pass rate with its 95 % Wilson interval, and the numbers of calls and errors."""
    low, high = summary.wilson_95
    parts = [
        f"passed {summary.passed} of {summary.counted}"
        f" (95 % Wilson interval {low:.3f} to {high:.3f})"
    ]
    if summary.called:
        share = 100.0 * summary.called / summary.episodes
        parts += [f"{summary.called} called for a person ({share:.0f} %)"]
    parts += [f"{summary.needless} of them without need"] if summary.needless else []
    parts += [f"{summary.errors} ended in error"] if summary.errors else []
    return ", ".join(parts)
