"""Tests of scripts that start processes: without a main guard they are refused, in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.slow import slow

PRELUDE = """
from scenarios.cli import main
from scenarios.workers.pool import run_side_by_side

def double(number):
    return 2 * number

def start():
    return sorted(run_side_by_side(double, [1, 2], 2, None))

"""
REFUSED = "import the script and start more: put the line below"


def run(folder, script):
    (folder / "script.py").write_text(PRELUDE + script)
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    words = [sys.executable, str(folder / "script.py")]
    return subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    "call",
    [slow("print(start())"), "print(run_side_by_side(double, [1], 2, None).send(None))"],
    ids=["in a function", "at the top"],
)
def test_a_script_without_a_guard_is_refused_before_a_process_starts(tmp_path, call):
    ended = run(tmp_path, call)
    assert ended.returncode == 1
    assert ended.stdout == ""
    assert ended.stderr.count("Traceback") == 1  # no other process has run into it
    line = len((PRELUDE + call).splitlines())
    last = ended.stderr.splitlines()[-1]
    assert f"{tmp_path / 'script.py'}:{line}: " in last
    assert REFUSED in last


@pytest.mark.parametrize(
    "words",
    [
        "run --planner scripted --controller idle --episodes 2 --workers 2",
        slow("view --controller idle"),
    ],
)
@pytest.mark.slow
def test_the_command_line_says_it_in_one_line(tmp_path, words):
    ended = run(tmp_path, f"import sys\nsys.exit(main({[*words.split(), '--out', 'out']!r}))")
    assert ended.returncode == 2
    (line,) = (line for line in ended.stderr.splitlines() if "calot:" in line)
    assert REFUSED in line
    assert "Traceback" not in ended.stderr


@pytest.mark.slow
def test_vector_environments_of_processes_are_refused_as_well(tmp_path):
    script = "from tissue_sim.vector import make_vec\nmake_vec(2, obs_mode='rgb')"
    ended = run(tmp_path, script)
    assert REFUSED in ended.stderr.splitlines()[-1]
    assert ended.stderr.count("Traceback") == 1


@pytest.mark.slow
def test_a_script_with_a_guard_runs(tmp_path):
    ended = run(tmp_path, "if __name__ == '__main__':\n    print(start())")
    assert (ended.stdout, ended.returncode) == ("[2, 4]\n", 0), ended.stderr


def test_a_program_that_is_no_file_needs_no_guard(tmp_path):
    """Check it with a program that another module holds, as processes import none then."""
    environment = os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])}
    program = (
        "from operator import neg\nfrom scenarios.workers.pool import run_side_by_side\n"
        "print(sorted(run_side_by_side(neg, [1, 2], 2, None)))"
    )
    words = [sys.executable, "-c", program]
    ended = subprocess.run(words, env=environment, capture_output=True, text=True, check=False)
    assert ended.stdout == "[-2, -1]\n", ended.stderr
