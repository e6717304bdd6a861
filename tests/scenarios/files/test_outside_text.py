"""Tests of outside text: it is shown, and it never commands a terminal, a page or the markup."""

import re
from html import unescape
from io import StringIO
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console
from rich.table import Table

from planner.instruction import TASKS, Instruction
from scenarios.files.outside_text import Terminal, in_html, visible
from scenarios.loop.observer import ProgressDisplay
from tests.scenarios.recording.made_up_step import random_step
from tissue_sim.patient.textbook import textbook_from_seed

SCENARIOS = Path(__file__).parents[3] / "scenarios"
HOSTILE = (
    "[/foo]",
    "[/INST] cut [bold]now[/bold]",
    "\x1b[2J\x1b]0;owned\x07 gone",
    "a\u202eb\u2066c",
    "\ud800 half a letter",
    "<script>alert(1)</script>",
)


@given(st.text())
def test_what_is_shown_holds_no_control_sequence_and_shows_the_same_twice(text):
    shown = visible(text)
    assert not {c for c in shown if not (c.isprintable() or c in "\n\t" or c.isspace())}
    assert visible(shown) == shown
    assert unescape(in_html(text)) == shown


@pytest.mark.parametrize("text", ["arrête\u00a0!", "再低一点", "[/foo]", ":smile: 3 < 4", "a\nb"])
def test_ordinary_text_stays_as_it_is(text):
    assert visible(text) == text


@pytest.mark.parametrize("text", HOSTILE)
def test_a_terminal_shows_markup_as_text_in_lines_tables_and_titles(text):
    table = Table(title=f"title {text}", min_width=120)
    table.add_column(text, overflow="fold")
    table.add_row(text)
    console = Terminal(width=200)
    console.file = StringIO()
    console.print(text)
    console.print(table)
    shown = console.file.getvalue()
    assert shown.count(visible(text)) == 4
    assert "\x1b]" not in shown


@pytest.mark.parametrize("text", HOSTILE)
def test_the_progress_bar_outlives_a_planner_that_says_anything(text):
    file = StringIO()
    with ProgressDisplay(1, Console(file=file, width=200, force_terminal=True)) as display:
        display.on_reset(SimpleNamespace(anatomy=textbook_from_seed(10_000)))
        said = Instruction(task=TASKS[0], remark=text)
        display.on_step(random_step(np.random.default_rng(0), 1, said, told=(text,)))
        display._progress.refresh()
    assert visible(text) in file.getvalue()
    assert "\x1b]0" not in file.getvalue()


def test_every_console_is_a_terminal():
    sources = [file.read_text() for file in SCENARIOS.rglob("*.py")]
    assert not [text for text in sources if re.search(r"[ =.]Console\(|rich\.markup", text)]
