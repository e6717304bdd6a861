"""Tests of a report's plots: what is drawn lies where its value is."""

import re

import numpy as np
import pytest
from matplotlib.figure import Figure

from scenarios.evaluation.page import ARMS, course, strips, svg

DOT = re.compile(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"[^>]*fill: var\(--arm0\)')
LINE = re.compile(r'<path d="([^"]*)"[^>]*stroke: var\(--arm0\)')


def dots(drawn: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in DOT.findall(drawn)]


def runs(drawn: str) -> list[list[tuple[float, float]]]:
    """Return the points of each unbroken part of the line."""
    parts = re.findall(r"M[^M]*", LINE.findall(drawn)[-1])
    return [
        [(float(x), float(y)) for x, y in re.findall(r"([\d.]+) ([\d.]+)", part)] for part in parts
    ]


@pytest.mark.parametrize("values", [(30.0, 10.0, 20.0), (40.0, 10.0, 30.0, 20.0), (10.0, 40.0)])
def test_the_bar_is_at_the_median_also_of_an_even_number(values):
    axes = Figure().add_subplot()
    strips(axes, [("a", ARMS[0], values)])
    drawn, bar = axes.lines
    assert sorted(drawn.get_xdata()) == sorted(values)
    assert set(bar.get_xdata()) == {float(np.median(values))}


def test_without_values_there_is_no_bar():
    axes = Figure().add_subplot()
    strips(axes, [("a", ARMS[0], ())])
    assert [len(line.get_xdata()) for line in axes.lines] == [0]


@pytest.mark.parametrize("values", [(0.4, 0.0, 0.2), (0.0, 0.0)])
def test_the_line_goes_through_the_dots_also_at_0(values):
    drawn = svg(course, [(ARMS[0], values)], "errors", 640, 146)
    assert runs(drawn) == [dots(drawn)]
    assert len(dots(drawn)) == len(values)


def test_the_line_is_broken_where_there_is_no_value():
    drawn = svg(course, [(ARMS[0], (0.4, None, 0.0, 0.2))], "errors", 640, 146)
    assert [len(run) for run in runs(drawn)][-1] == 2
    assert len(dots(drawn)) == 3


def test_a_plot_is_the_same_each_time_and_names_no_colour_of_its_own():
    once, again = (svg(course, [(ARMS[0], (0.4, 0.1))], "a<b", 640, 146) for _ in range(2))
    assert once == again
    assert 'aria-label="a&lt;b"' in once
    assert not re.search("#[0-9a-f]{6}", once)
