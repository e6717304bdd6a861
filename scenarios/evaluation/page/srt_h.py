"""The section that compares the systems with SRT-H and with its surgeon."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from scenarios.evaluation import published
from scenarios.evaluation.figures import TaskFigures
from scenarios.evaluation.page.parts import section, table
from scenarios.evaluation.report import Report
from scenarios.evaluation.words import NOTHING, number, passed
from scenarios.files.outside_text import in_html


def beside_srt_h(report: Report) -> str:
    """Return the comparison in the first suite; SRT-H's patients were undisturbed, too.

    A suite with ladders does not count. The section is empty if there is no other suite.
    """
    if (first := report.headline) is None:
        return ""
    name = first.name
    arms = [found.suites[name] for found in report.arms.values()]
    head = ("", *(in_html(arm) for arm in report.arms), "SRT-H", "its surgeon")
    seconds, corrections = published.DURATIONS_S, published.CORRECTIONS
    rows: list[Sequence[str]] = [
        ("procedures passed", *(passed(a.summary) for a in arms),
         f"{published.PASSED} of {published.GALLBLADDERS}", NOTHING),
        ("procedure (s)", *(number(a.figures.time_s, 0) for a in arms),
         f"{sum(seconds) / len(seconds):.0f}", NOTHING),
        ("self-corrections", *(number(a.figures.corrections, 1) for a in arms),
         f"{sum(corrections) / len(corrections):.1f}", NOTHING),
    ]  # fmt: skip
    for task in published.TASKS:
        mine = [a.tasks[task.name] for a in arms]
        rows += _task_rows(task, mine)
    return section(
        "Beside SRT-H and its surgeon",
        f"Means in {in_html(name)}: times, paths and jerks over the episodes that passed,"
        " corrections over all that passed or failed. SRT-H worked on eight pig gallbladders, in"
        f" time on the clock ({published.SOURCE}); Calot's time is simulated: a scale to read by,"
        " not a race. SRT-H prints its jerk in mm/s³; by its size it is taken to be the third"
        " difference between frames at 30 Hz, as ours is.",
        table(head, 1, rows),
    )


def _task_rows(
    task: published.PublishedTask, mine: Sequence[TaskFigures]
) -> Iterator[Sequence[str]]:
    yield f"{task.name} (s)", *(number(m.time_s, 1) for m in mine), *map(str, task.time_s)
    paths = (number(p, 1, 1e3) for p in task.path_m)
    yield f"{task.name}: path (mm)", *(number(m.path_m, 1, 1e3) for m in mine), *paths
    if task.jerk_m is not None:
        jerks = (number(j, 1, 1e6) for j in task.jerk_m)
        yield f"{task.name}: jerk (µm/step³)", *(number(m.jerk_m, 1, 1e6) for m in mine), *jerks
