"""The section with the strength of a disturbance that breaks a system."""

from __future__ import annotations

from collections.abc import Sequence

from scenarios.evaluation.page.parts import legend, section
from scenarios.evaluation.page.plots import PlotLine, ladder
from scenarios.evaluation.page.sheet import N_COLOURS
from scenarios.evaluation.report import Climb, Report
from scenarios.evaluation.words import end_of
from scenarios.files.outside_text import in_html


def ladders(report: Report) -> str:
    climbing = [suite for suite in report.suites if suite.ladders]
    figures = "".join(
        _ladder(
            f"{suite.name}: {ladder.axis}" if len(climbing) > 1 else ladder.axis,
            [found.suites[suite.name].climbs[k] for found in report.arms.values()],
            ladder.rungs[-1].magnitude or 1.0,
        )
        for suite in climbing
        for k, ladder in enumerate(suite.ladders)
    )
    return section(
        "How much it takes to break",
        "Each disturbance grows until fewer than half of the patients pass; that is the breaking"
        " point. Whiskers are 95 % Wilson intervals.",
        f"{legend(report)}<div class='several'>{figures}</div>" if figures else "",
    )


def _ladder(name: str, climbs: Sequence[Climb], most: float) -> str:
    lines = [
        PlotLine(
            colour=k % N_COLOURS,
            points=tuple(
                (rung.magnitude, rung.summary.pass_rate, *rung.summary.wilson_95)
                for rung in climb.rungs
                if rung.summary.pass_rate is not None
            ),
        )
        for k, climb in enumerate(climbs)
    ]
    breaks = "".join(
        f"<span class='once'><span class='dot arm{k % N_COLOURS}'></span>{end_of(climb)}</span> "
        for k, climb in enumerate(climbs)
    )
    return (
        f"<figure><h3>{in_html(name)}</h3>{ladder(lines, most)}"
        f"<figcaption>{in_html(climbs[0].unit)}<br>{breaks}</figcaption></figure>"
    )
