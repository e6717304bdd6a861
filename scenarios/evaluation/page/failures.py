"""The section with the reasons of failed episodes, and the episodes to look at."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scenarios.evaluation.page.parts import arm_name, folded, section, table
from scenarios.evaluation.report import ArmReport, Report, ReportedEpisode
from scenarios.files.outside_text import in_html

EPISODE = ("arm", "recording", "outcome")


def failures(report: Report) -> str:
    reasons = [
        (
            arm_name(k, arm),
            in_html(name),
            in_html(reason),
            str(count),
        )
        for k, (arm, found) in enumerate(report.arms.items())
        for name, suite in found.suites.items()
        for reason, count in suite.reasons.items()
    ]
    to_look_at = _episodes(report, lambda arm: (*arm.errors, *arm.needless_calls, *arm.worst))
    right_calls = _episodes(report, lambda arm: arm.right_calls)
    return section(
        "Why, and which to look at",
        "What went wrong first in each failed episode. Below, errors, episodes in which the planner"
        " called for a person without need, and the worst episodes: those that failed earliest,"
        " then the slowest that passed. Watch one with <code>calot replay FILE --view</code>.",
        table(("arm", "suite", "reason", "episodes"), 3, reasons)
        + "<div style='height:18px'></div>"
        + table(EPISODE, len(EPISODE), to_look_at)
        + folded(f"{len(right_calls)} rightly called", table(EPISODE, len(EPISODE), right_calls)),
    )


def _episodes(
    report: Report, which: Callable[[ArmReport], Sequence[ReportedEpisode]]
) -> list[Sequence[str]]:
    return [
        (arm_name(k, arm), _place(episode), in_html(episode.outcome))
        for k, (arm, found) in enumerate(report.arms.items())
        for episode in which(found)
    ]


def _place(episode: ReportedEpisode) -> str:
    return (
        f"<a href='{in_html(episode.recording)}'>{in_html(episode.condition)},"
        f" seed {episode.seed}</a>"
    )
