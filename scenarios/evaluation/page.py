"""A report as one page of HTML that needs no network, with its plots as SVG.

The colours of the plots are variables of the page's style sheet.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from io import StringIO
from pathlib import Path
from statistics import median
from textwrap import fill
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import PercentFormatter

from scenarios.evaluation import published
from scenarios.evaluation.report import Climb, Report, SuiteReport
from scenarios.evaluation.tables import tables
from scenarios.evaluation.words import counts, interval, rate
from scenarios.files.outside_text import in_html, templates
from scenarios.files.strict_json import dumps
from scenarios.loop.sensing_metrics import SPAN_S

ARMS = tuple(f"#a0000{k}" for k in range(6))
VARIABLES = {"#a00010": "ink", "#a00011": "soft", "#a00012": "rule"}
VARIABLES |= {colour: f"arm{k}" for k, colour in enumerate(ARMS)}
"""Stand-ins, here and in plots.mplstyle, for colours of the sheet, which has others in the dark."""

DASHED = {"color": "#a00011", "linewidth": 1.0, "linestyle": (0, (3, 4))}


def page(report: Report, made_with: Mapping[str, Any]) -> str:
    """Return the whole page; its links to recordings are paths in the report's folder."""
    template = templates(Path(__file__).parent).get_template("page.html.jinja")
    return template.render(
        report=report,
        colours={arm: f"arm{k % len(ARMS)}" for k, arm in enumerate(report.arms)},
        tables=tables(report),
        plots=plots(report),
        words={"counts": counts, "interval": interval, "rate": rate},
        source=published.SOURCE,
        span_s=SPAN_S,
        made_with=dumps(made_with, indent=2),
    )


def plots(report: Report) -> dict[str, dict[str, str]]:
    """Return the plots by the page's names for their sections, and by their titles."""
    colours = {arm: ARMS[k % len(ARMS)] for k, arm in enumerate(report.arms)}
    found = list(_groups(report, colours))
    times_s = [(label, c, _times_s(suite)) for label, c, suite in found]
    told = [(colours[arm], of_arm.failure_detection) for arm, of_arm in report.arms.items()]
    curves = [(c, d.roc) for c, d in told if d is not None and d.roc_auc is not None]
    sensed = next(filter(None, (_sensed(report, s.name, colours) for s in report.suites)), None)
    n = len(found)
    drawn = {
        "rates": found and svg(forest, found, "pass rates and their intervals", 340, 26 * n),
        "times": any(t for *_, t in times_s) and svg(strips, times_s, "times", 520, 34 * n),
        "sensed": sensed and svg(course, sensed, "errors over time", 640, 146),
        "foresight": curves and svg(roc, curves, "failures caught over false alarms", 216, 216),
    }
    whole = {name: {"": plot} if plot else {} for name, plot in drawn.items()}
    return whole | {"ladders": dict(_ladders(report, tuple(colours.values())))}


def _groups(report: Report, colours: dict[str, str]) -> Iterator[tuple[str, str, SuiteReport]]:
    """Yield label, colour and results of each system in each suite without ladders."""
    for suite in report.suites:
        for arm, found in report.arms.items() if not suite.ladders else ():
            label = f"{suite.name}: {arm}" if len(report.suites) > 1 else arm
            yield label, colours[arm], found.suites[suite.name]


def _times_s(suite: SuiteReport) -> list[float]:
    return [found["procedure_time_s"] for found in suite.episodes if found["success"]]


def _sensed(report: Report, suite: str, colours: dict[str, str]) -> list[tuple[str, Any]]:
    """Return the colours and the errors over time (m), as far as measured, in a suite."""
    return [
        (colours[arm], sensed.over_time_m)
        for arm, found in report.arms.items()
        for sensed in found.suites[suite].sensed
        if any(error is not None for error in sensed.over_time_m)
    ]


def _ladders(report: Report, colours: Sequence[str]) -> Iterator[tuple[str, str]]:
    climbing = [suite for suite in report.suites if suite.ladders]
    for suite in climbing:
        for k, rungs in enumerate(suite.ladders):
            title = f"{suite.name}: {rungs.axis}" if len(climbing) > 1 else rungs.axis
            climbs = [found.suites[suite.name].climbs[k] for found in report.arms.values()]
            data = (rungs.rungs[-1].magnitude or 1.0, list(zip(colours, climbs, strict=False)))
            yield title, svg(ladder, data, f"pass rate over magnitude: {title}", 204, 112)


def svg(
    draw: Callable[[Axes, Any], None], data: Any, said: str, width_px: float, height_px: float
) -> str:
    """Return a drawing as an element of HTML; the size is that of its axes, without labels."""
    file = StringIO()
    with matplotlib.rc_context(fname=Path(__file__).with_name("plots.mplstyle")):
        figure = Figure(figsize=(width_px / 72.0, height_px / 72.0))
        draw(figure.add_axes((0.0, 0.0, 1.0, 1.0)), data)
        metadata = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        figure.savefig(file, format="svg", transparent=True, bbox_inches="tight", metadata=metadata)
    text = NO_HTML.sub("", file.getvalue())
    for colour, name in VARIABLES.items():
        text = text.replace(colour, f"var(--{name})")
    return text.replace("<svg ", f'<svg role="img" aria-label="{in_html(said)}" ', 1)


NO_HTML = re.compile(
    r"^.*?(?=<svg)|<!--.*?-->|<metadata>.*?</metadata>| xmlns[^=]*=\"[^\"]*\""
    r"| clip-path=\"[^\"]*\"|(?<=\d)pt(?=\")",
    re.DOTALL,
)
"""What an SVG file has, but not an element of HTML: a head, names of its parts, units."""


def forest(axes: Axes, groups: Sequence[tuple[str, str, SuiteReport]]) -> None:
    """Draw a row for each system in a suite: its pass rate as a dot in its interval."""
    for y, (_, colour, suite) in enumerate(groups):
        axes.plot(suite.summary.wilson_95, (y, y), color=colour, linewidth=3.0)
        if (rate := suite.summary.pass_rate) is not None:
            axes.plot(rate, y, "o", color=colour, markersize=11.0)
        axes.text(
            1.04, y, counts(suite.summary, suite.missing), verticalalignment="center_baseline"
        )
    axes.set(xlim=(-0.01, 1.01), xticks=(0.0, 0.25, 0.5, 0.75, 1.0))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, 0, " %"))
    _rows(axes, [label for label, *_ in groups])


def strips(axes: Axes, groups: Sequence[tuple[str, str, Sequence[float]]]) -> None:
    """Draw a row of times for each system in a suite: dots, and a bar at their median."""
    for y, (_, colour, values) in enumerate(groups):
        heights = [y + 0.15 * (k % 3 - 1) for k in range(len(values))]
        axes.plot(sorted(values), heights, "o", color=colour, markersize=8.0, alpha=0.45,
                  markeredgewidth=0.0)  # fmt: skip
        if values:
            axes.plot([median(values)] * 2, (y - 0.35, y + 0.35), color=colour, linewidth=3.0)
    axes.set(xlim=(0.0, None), xlabel="s, simulated")
    _rows(axes, [label for label, *_ in groups])


def _rows(axes: Axes, labels: Sequence[str]) -> None:
    axes.set_yticks(range(len(labels)), labels, color="#a00010", fontsize=13.0)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")


def course(axes: Axes, lines: Sequence[tuple[str, Sequence[float | None]]]) -> None:
    """Draw errors over time, a line for each system, broken where nothing was measured."""
    for colour, errors_m in lines:
        errors_mm = 1e3 * np.array(errors_m, float)
        axes.plot(SPAN_S * (np.arange(len(errors_mm)) + 0.5), errors_mm, "o-", color=colour,
                  markersize=5.0)  # fmt: skip
    axes.set(xlim=(0.0, None), ylim=(0.0, None), xlabel="s, simulated", ylabel="mm off")


def ladder(axes: Axes, data: tuple[float, Sequence[tuple[str, Climb]]]) -> None:
    """Draw pass rates up to the largest magnitude, with intervals; a dashed line marks half."""
    most, climbs = data
    axes.axhline(0.5, **DASHED)
    for k, (colour, climb) in enumerate(climbs):
        shift = 0.02 * most * (k - 0.5 * (len(climbs) - 1))  # systems stand beside one another
        rungs = [rung for rung in climb.rungs if rung.summary.pass_rate is not None]
        at = [rung.magnitude + shift for rung in rungs]
        rates = [rung.summary.pass_rate or 0.0 for rung in rungs]
        axes.plot(at, rates, "o-", color=colour, markersize=7.0)
        for x, rung in zip(at, rungs, strict=True):
            axes.plot((x, x), rung.summary.wilson_95, color=colour, linewidth=1.5, alpha=0.5)
    axes.set(xlim=(-0.04 * most, 1.06 * most), ylim=(-0.03, 1.03))
    axes.set(xticks=(0.0, 0.5 * most, most), yticks=(0.0, 0.5, 1.0))
    axes.set_xlabel(fill(climbs[0][1].unit, 36))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, 0, " %"))
    axes.grid(visible=False, axis="x")


def roc(axes: Axes, curves: Sequence[tuple[str, Sequence[tuple[float, float]]]]) -> None:
    """Draw failures caught over false alarms, a curve for each system."""
    axes.axline((0.0, 0.0), (1.0, 1.0), **DASHED)
    for colour, curve in curves:
        axes.plot(*np.transpose(curve), color=colour)
    axes.set(
        xlim=(-0.01, 1.01), ylim=(-0.01, 1.01), xlabel="false alarms", ylabel="failures caught"
    )
    axes.set(xticks=(0.0, 0.5, 1.0), yticks=(0.0, 0.5, 1.0))
    axes.xaxis.set_major_formatter(PercentFormatter(1.0, 0, " %"))
    axes.yaxis.set_major_formatter(PercentFormatter(1.0, 0, " %"))
