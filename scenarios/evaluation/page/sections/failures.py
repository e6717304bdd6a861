"""Why episodes failed, and which to look at."""

from __future__ import annotations

from html import escape

from scenarios.evaluation.page.parts import arm_name, section, table
from scenarios.evaluation.report import Report, ReportedEpisode


def failures(report: Report) -> str:
    reasons = [
        (
            arm_name(k, arm),
            escape(name),
            escape(reason),
            str(count),
        )
        for k, (arm, found) in enumerate(report.arms.items())
        for name, suite in found.suites.items()
        for reason, count in suite.reasons.items()
    ]
    episodes = [
        (arm_name(k, arm), _place(episode), escape(episode.outcome))
        for k, (arm, found) in enumerate(report.arms.items())
        for episode in (*found.errors, *found.called, *found.worst)
    ]
    return section(
        "Why, and which to look at",
        "What went wrong first in each failed episode. Below, errors, episodes in which the planner"
        " called for a person, and the worst episodes: those that failed earliest, then the slowest"
        " that passed. Watch one with"
        " <code>calot replay FILE --view</code>.",
        table(("arm", "suite", "reason", "episodes"), 3, reasons)
        + "<div style='height:18px'></div>"
        + table(("arm", "recording", "outcome"), 9, episodes),
    )


def _place(episode: ReportedEpisode) -> str:
    return (
        f"<a href='{escape(episode.recording, quote=True)}'>{escape(episode.condition)},"
        f" seed {episode.seed}</a>"
    )
