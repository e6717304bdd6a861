"""Tests of a report's drawings: what is drawn lies where its value is."""

import re

import pytest

from scenarios.evaluation.page.plots import course, strips

DOT = re.compile(r'<circle class="arm0 [a-z]+" cx="([\d.]+)" cy="([\d.]+)"')
BAR = re.compile(r'<line class="arm0 span" x1="([\d.]+)"')
LINE = re.compile(r'points="([^"]*)"')


def dots(svg: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in DOT.findall(svg)]


@pytest.mark.parametrize(
    ("values", "between"),
    [((30.0, 10.0, 20.0), (1, 1)), ((40.0, 10.0, 30.0, 20.0), (1, 2)), ((10.0, 40.0), (0, 1))],
)
def test_the_bar_is_at_the_median_also_of_an_even_number(values, between):
    """The median is in the middle of these two of the dots, which rise."""
    svg = strips([("a", 0, values)], "s")
    low, high = (dots(svg)[k][0] for k in between)
    (bar,) = BAR.findall(svg)
    assert float(bar) == pytest.approx(0.5 * (low + high), abs=0.11)


def test_without_values_there_is_no_bar():
    assert not BAR.search(strips([("a", 0, ())], "s"))


@pytest.mark.parametrize("values", [(0.4, 0.0, 0.2), (0.0, 0.0)])
def test_the_line_goes_through_the_dots_also_at_0(values):
    svg = course([(0, values)], 5.0, "mm off")
    (line,) = LINE.findall(svg)
    assert [tuple(map(float, point.split(","))) for point in line.split()] == dots(svg)


def test_the_line_is_broken_where_there_is_no_value():
    svg = course([(0, (0.4, None, 0.0, 0.2))], 5.0, "mm off")
    assert [len(line.split()) for line in LINE.findall(svg)] == [1, 2]
    assert len(dots(svg)) == 3
