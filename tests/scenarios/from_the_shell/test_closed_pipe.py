"""Tests of commands whose output nobody reads any more, as in `calot run | head -1`."""

import json
import os
import subprocess
import sys

import pytest

from scenarios.files.errors import ERROR
from tests.slow import slow

BREAKS_OFF = "tests.scenarios.from_the_shell.test_broken_off:SaysText"
RUN = ["run", "--scenario", "textbook", "--seed", "10004", "--planner", BREAKS_OFF]
RUN += ["--controller", "idle"]


def unread(words, *streams):
    """Run a command with these streams into a pipe without a reader; return code and the rest."""
    reading, writing = os.pipe()
    os.close(reading)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | dict.fromkeys(streams, writing)
    done = subprocess.run(
        [sys.executable, "-m", "scenarios.cli", *words], **pipes, text=True, check=False
    )
    os.close(writing)
    return done.returncode, (done.stdout or "") + (done.stderr or "")


@pytest.mark.parametrize("streams", [("stdout",), slow(("stdout", "stderr"))])
def test_a_run_that_nobody_reads_ends_with_its_own_code_and_its_results(streams, tmp_path):
    code, rest = unread([*RUN, "--out", str(tmp_path)], *streams)
    (episode,) = json.loads((tmp_path / "results.json").read_text())["episodes"]
    assert code == ERROR  # and not 1, which rich's consoles end with
    assert episode["error"].startswith("TypeError: planner: plan returned a str")
    assert "Traceback" not in rest
    assert "BrokenPipe" not in rest


@pytest.mark.parametrize(
    ("words", "streams", "code"),
    [
        (["--version"], ("stdout",), 0),
        slow(["--help"], ("stdout",), 0),
        slow(["run", "--seed", "x"], ("stderr",), 2),
        (["replay", "nowhere.npz"], ("stderr",), 2),
    ],
)
def test_other_commands_end_quietly(words, streams, code):
    assert unread(words, *streams) == (code, "")
