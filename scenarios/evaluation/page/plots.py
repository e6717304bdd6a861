"""Drawings of a report as SVG text, in the colours that the page's sheet gives to systems."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from statistics import median

from scenarios.evaluation.words import rate as in_percent
from scenarios.files.outside_text import in_html

ROW, LABEL, PLOT, NOTE = 26, 210, 470, 150  # px of a forest


@dataclass(frozen=True, kw_only=True)
class PlotMark:
    """A value, 0 to 1, with its interval; `colour` is the system's number, `note` a text beside."""

    label: str
    colour: int
    value: float | None
    ends: tuple[float, float]
    note: str


def forest(marks: Sequence[PlotMark]) -> str:
    """Draw one row for each mark: a dot in its interval, on an axis from 0 to 1."""
    height = ROW * len(marks) + 30
    ticks = "".join(
        f'<line class="grid" x1="{_at(x):.1f}" x2="{_at(x):.1f}" y1="4" y2="{height - 24}"/>'
        f'<text class="tick" x="{_at(x):.1f}" y="{height - 8}">{in_percent(x)}</text>'
        for x in (0.0, 0.25, 0.5, 0.75, 1.0)
    )
    rows = "".join(_row(mark, 4 + ROW * (k + 0.5)) for k, mark in enumerate(marks))
    return _svg(LABEL + PLOT + NOTE, height, "pass rates with their intervals", ticks + rows)


def _row(mark: PlotMark, y: float) -> str:
    low, high = (_at(end) for end in mark.ends)
    dot = ""
    if mark.value is not None:
        dot = (
            f'<circle class="arm{mark.colour} solid" cx="{_at(mark.value):.1f}" cy="{y}" r="5.5"/>'
        )
    return (
        f'<text class="name" x="{LABEL - 14}" y="{y + 4}">{in_html(mark.label)}</text>'
        f'<line class="arm{mark.colour} span" x1="{low:.1f}" x2="{high:.1f}" y1="{y}" y2="{y}"/>'
        f'{dot}<text class="note" x="{LABEL + PLOT + 16}" y="{y + 4}">{in_html(mark.note)}</text>'
    )


def _at(value: float) -> float:
    return LABEL + PLOT * value


@dataclass(frozen=True, kw_only=True)
class PlotLine:
    """A system's pass rate along a ladder: (magnitude, rate, low, high) of each rung."""

    colour: int
    points: tuple[tuple[float, float, float, float], ...]


def ladder(lines: Sequence[PlotLine], most: float) -> str:
    """Draw pass rate over magnitude up to `most`; a dashed line marks the breaking rate, half."""
    width, height, left, low, top = 250, 150, 34, 122, 10

    def x(magnitude: float) -> float:
        return left + (width - left - 12) * magnitude / most

    def y(rate: float) -> float:
        return low - (low - top) * rate

    axes = "".join(
        f'<line class="{"half" if r == 0.5 else "grid"}" x1="{left}" x2="{width - 6}"'
        f' y1="{y(r):.1f}" y2="{y(r):.1f}"/>'
        f'<text class="tick end" x="{left - 6}" y="{y(r) + 4:.1f}">{in_percent(r)}</text>'
        for r in (0.0, 0.5, 1.0)
    )
    axes += "".join(
        f'<text class="tick" x="{x(m):.1f}" y="{height - 10}">{m:g}</text>'
        for m in (0.5 * most, most)
    )
    shift = -2.0 * (len(lines) - 1)
    drawn = "".join(
        _line(
            line.colour,
            [(x(m) + shift + 4 * k, y(r), y(lo), y(hi)) for m, r, lo, hi in line.points],
        )
        for k, line in enumerate(lines)
    )
    return _svg(width, height, "pass rate over magnitude", axes + drawn)


def _line(colour: int, points: Sequence[tuple[float, float, float, float]]) -> str:
    path = " ".join(f"{x:.1f},{y:.1f}" for x, y, _, _ in points)
    spans = "".join(
        f'<line class="arm{colour} thin" x1="{x:.1f}" x2="{x:.1f}" y1="{low:.1f}" y2="{high:.1f}"/>'
        f'<circle class="arm{colour} solid" cx="{x:.1f}" cy="{y:.1f}" r="3.5"/>'
        for x, y, low, high in points
    )
    return f'<polyline class="arm{colour} line" points="{path}"/>{spans}'


def course(lines: Sequence[tuple[int, Sequence[float | None]]], span_s: float, unit: str) -> str:
    """Draw values over time, a line (colour, values of the spans) for each system; None: a gap."""
    width, height, left, low, top = LABEL + PLOT, 190, 44, 156, 10
    most = 1.1 * max((v for _, values in lines for v in values if v is not None), default=1.0)
    most = most or 1.0  # all values are 0
    spans = 1 + max(k for _, values in lines for k, v in enumerate(values) if v is not None)

    def x(k: float) -> float:
        return left + (width - left - 12) * k / spans

    def y(value: float) -> float:
        return low - (low - top) * value / most

    axes = "".join(
        f'<line class="grid" x1="{left}" x2="{width - 6}" y1="{y(v):.1f}" y2="{y(v):.1f}"/>'
        f'<text class="tick end" x="{left - 6}" y="{y(v) + 4:.1f}">{v:g}</text>'
        for v in (0.0, float(f"{0.5 * most:.1g}"))
    )
    axes += "".join(
        f'<text class="tick" x="{x(k):.1f}" y="{height - 14}">{span_s * k:g} s</text>'
        for k in range(0, spans + 1, max(spans // 8, 1))
    )
    drawn = "".join(
        f'<circle class="arm{colour} solid" cx="{x(k + 0.5):.1f}" cy="{y(v):.1f}" r="3"/>'
        for colour, values in lines
        for k, v in enumerate(values)
        if v is not None
    )
    drawn += "".join(
        f'<polyline class="arm{colour} line" points="{points}"/>'
        for colour, values in lines
        for points in _unbroken(
            [(x(k + 0.5), None if v is None else y(v)) for k, v in enumerate(values)]
        )
    )
    return _svg(width, height, f"{unit} over time", axes + drawn)


def _unbroken(points: Sequence[tuple[float, float | None]]) -> Iterator[str]:
    """Yield the runs of points that have a value, as SVG writes them."""
    for known, run in groupby(points, key=lambda point: point[1] is not None):
        if known:
            yield " ".join(f"{x:.1f},{y:.1f}" for x, y in run)


def strips(groups: Sequence[tuple[str, int, Sequence[float]]], unit: str) -> str:
    """Draw one row for each group (label, colour, values): dots, and a bar at their median."""
    most = 1.08 * max((value for _, _, values in groups for value in values), default=1.0)
    height = 34 * len(groups) + 30

    def x(value: float) -> float:
        return LABEL + PLOT * value / most

    ticks = "".join(
        f'<line class="grid" x1="{x(v):.1f}" x2="{x(v):.1f}" y1="4" y2="{height - 24}"/>'
        f'<text class="tick" x="{x(v):.1f}" y="{height - 8}">{v:g}</text>'
        for v in _round_values(most)
    )
    rows = "".join(
        _strip(label, colour, [x(value) for value in sorted(values)], 4 + 34 * (k + 0.5))
        for k, (label, colour, values) in enumerate(groups)
    )
    named = f'<text class="note" x="{LABEL + PLOT + 16}" y="{height - 8}">{in_html(unit)}</text>'
    return _svg(LABEL + PLOT + NOTE, height, unit, ticks + rows + named)


def _strip(label: str, colour: int, at: Sequence[float], y: float) -> str:
    dots = "".join(
        f'<circle class="arm{colour} faint" cx="{x:.1f}" cy="{y + 5 * (k % 3 - 1)}" r="4"/>'
        for k, x in enumerate(at)
    )
    bar = ""
    if at:
        middle = median(at)
        bar = (
            f'<line class="arm{colour} span" x1="{middle:.1f}" x2="{middle:.1f}"'
            f' y1="{y - 12}" y2="{y + 12}"/>'
        )
    name = f'<text class="name" x="{LABEL - 14}" y="{y + 4}">{in_html(label)}</text>'
    return name + dots + bar


def _round_values(most: float) -> list[float]:
    """Return values from 0 in four to eight steps of 1, 2 or 5 times a power of ten."""
    step = 10.0 ** len(str(int(most)))
    while most / step < 4:
        step = step / 2 if str(step)[0] in "12" else step / 2.5
    return [step * k for k in range(int(most / step) + 1)]


def roc(curves: Sequence[tuple[int, Sequence[tuple[float, float]]]]) -> str:
    """Draw failures caught over false alarms, one curve (colour, points) for each system."""
    size, left, low = 260, 44, 226

    def points(curve: Sequence[tuple[float, float]]) -> str:
        side = low - 10
        return " ".join(f"{left + side * x:.1f},{low - side * y:.1f}" for x, y in curve)

    frame = f'<polyline class="half" points="{points(((0, 0), (1, 1)))}"/>'
    frame += f'<polyline class="grid" points="{points(((0, 1), (0, 0), (1, 0)))}"/>'
    drawn = "".join(f'<polyline class="arm{c} line" points="{points(p)}"/>' for c, p in curves)
    names = (
        f'<text class="tick" x="{left + 108}" y="{size - 10}">false alarms</text>'
        f'<text class="tick" transform="translate(16 118) rotate(-90)">failures caught</text>'
    )
    return _svg(size, size, "receiver operating characteristic", frame + drawn + names)


def _svg(width: float, height: float, said: str, inside: str) -> str:
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" role="img"'
        f' aria-label="{in_html(said)}">{inside}</svg>'
    )
