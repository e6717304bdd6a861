"""Tests of `calot evaluate`: run, interrupted, resumed; exit codes."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from scenarios.catalogue import CONTROLLERS, PolicyEntry
from scenarios.cli import main
from scenarios.evaluation.arm import arm_from_text
from scenarios.recording.first_difference import BY_THE_CLOCK
from scenarios.recording.recorder import load
from tests.scenarios.breaking_controller import BREAKS
from tests.scenarios.evaluation.made_up import episode, plan, record
from tests.scenarios.procedures import SEED_BY_COMMAND

ROOT = Path(__file__).parents[3]
SEEDS = (SEED_BY_COMMAND, 10_004)
PAIR = ["--arms", "filtered=scripted+expert", "free=scripted+expert,filter=off"]


def words(out, *more):
    arms = [] if "--arms" in more else ["--arms", "scripted+expert"]
    seeds = ["--seed", str(SEEDS[0]), "--episodes", "2"]
    suite = [] if "--suite" in more else ["--suite", "textbook"]
    return ["evaluate", *arms, *seeds, *suite, "--out", str(out), *more]


def told(out):
    """Return the content of results.json without wall times, which are in the hashes, too."""
    return json.loads(
        (out / "results.json").read_text(),
        object_hook=lambda entry: {
            k: v for k, v in entry.items() if k not in (*BY_THE_CLOCK, "recordings")
        },
    )


def recordings(out):
    return sorted(out.glob("scripted+expert/textbook/textbook/episodes/*.npz"))


@pytest.fixture(scope="module")
def whole(procedure, ran_by_command, tmp_path_factory):
    """Return a finished evaluation whose episodes other commands recorded, one in a process."""
    out = tmp_path_factory.mktemp("whole")
    recorded = out / "scripted+expert" / "textbook" / "textbook" / "episodes"
    recorded.mkdir(parents=True)
    for recording in (procedure.file, ran_by_command[0] / "episodes" / f"{SEEDS[0]}.npz"):
        shutil.copy(recording, recorded)
    assert main(words(out)) == 0
    return out


@pytest.fixture
def half(whole, tmp_path):
    """Return what is left after a worker was killed in the first episode."""
    out = tmp_path / "half"
    shutil.copytree(whole, out)
    recordings(out)[0].unlink()
    (out / "results.json").unlink()
    return out


def test_the_report_tells_what_was_recorded(whole):
    (episode, other) = told(whole)["arms"]["scripted+expert"]["suites"]["textbook"]["episodes"]
    assert (episode["seed"], other["seed"]) == SEEDS
    recorded = load(recordings(whole)[0]).result
    assert recorded is not None
    assert episode["tasks"] == recorded["tasks"]
    assert all(task["path_m"][1] > 0.005 for task in episode["tasks"][1:])
    assert "<section>" in (whole / "report.html").read_text()


@pytest.mark.slow
def test_resumed_it_runs_only_the_lost_episode_and_ends_the_same(whole, half):
    (kept,), lost = recordings(half), recordings(whole)[0]
    before = kept.stat().st_mtime_ns
    assert main(words(half)) == 0
    assert kept.stat().st_mtime_ns == before
    assert told(half) == told(whole)
    again, once = load(recordings(half)[0]).arrays, load(lost).arrays
    assert again.keys() == once.keys()
    for name, array in once.items():
        np.testing.assert_array_equal(again[name], array)


def test_when_all_is_finished_the_report_is_made_again_to_the_byte(whole):
    made = [(whole / name).read_bytes() for name in ("results.json", "report.html")]
    assert main(words(whole)) == 0
    assert [(whole / name).read_bytes() for name in ("results.json", "report.html")] == made


@pytest.mark.parametrize(("limit", "code"), [("0.5", 0), ("0.51", 1)])
def test_a_pass_rate_below_the_limit_is_exit_code_1(tmp_path, capfd, limit, code):
    arm = arm_from_text("scripted+expert")
    for case in plan("textbook", arms=(arm,), seeds=SEEDS).due({}):
        record(case, tmp_path, episode(case, passed=case.seed == SEEDS[0]))
    assert main(words(tmp_path, "--fail-under", limit)) == code
    assert ("passes 0.500 of textbook" in capfd.readouterr().out) == bool(code)


def test_errors_give_exit_code_3_even_if_others_passed(tmp_path, monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    out = str(tmp_path)
    once = ["evaluate", "--arms", "a=scripted+breaks", "--suite", "textbook"]
    once += ["--seed", "10004", "--episodes", "1"]
    assert main([*once, "--out", out, "--fail-under", "1.0"]) == 3
    (error,) = told(tmp_path)["arms"]["a"]["errors"]
    assert error["outcome"] == "error: RuntimeError: a string snapped"


def complaint(capfd, *said, begun=False):
    """Return the one line on bad input; lines come before it only if episodes have `begun`."""
    assert main(["evaluate", *said]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    *before, line = filter(None, err.splitlines())
    assert bool(before) == begun
    return line


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (["--suite", "zoo"], ["--suite", "'zoo'", "nominal", "variants", "language"]),
        (["--suite", "nominal,zoo"], ["--suite", "'zoo'", "nominal"]),
        (["--suite", ""], ["--suite", "''", "nominal"]),
        (["--arms", "expert"], ["--arms", "'expert'", "NAME=PLANNER+CONTROLLER"]),
        (["--arms", "a=scripted+zoo"], ["--arms", "'zoo'", "expert", "idle"]),
        (["--arms", "a=zoo+expert"], ["--arms", "'zoo'", "scripted", "learned"]),
        (["--arms", "a=scripted+idle", "a=scripted+expert"], ["--arms", "a is there twice"]),
        (["--arms", "a=scripted+diffusion,checkpoint=no.st"], ["--arms a: ,checkpoint=: no.st"]),
        (
            ["--arms", "a=learned+expert,planner-checkpoint=no.st"],
            ["--arms a: ,planner-checkpoint=: no.st"],
        ),
        (
            [
                "--arms",
                "learned+expert",
                "b=learned+expert,perception-checkpoint=no.st,sense=cameras",
            ],
            ["--arms b: ,perception-checkpoint=: no.st"],
        ),
        (["--arms", "b=learned+nowhere:make"], ["--arms b: controller nowhere:make: ", "nowhere"]),
        (["--fail-under", "1.5"], ["--fail-under", "1.5", "0 to 1"]),
        (["--fail-under", "nan"], ["--fail-under", "nan", "0 to 1"]),
        (["--episodes", "0"], ["--episodes", "'0'", "at least 1"]),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing_behind(capfd, tmp_path, monkeypatch, given, said):
    monkeypatch.chdir(tmp_path)
    line = complaint(capfd, *given)
    assert all(word in line for word in said)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_another_version_is_one_line_and_stays(capfd, half):
    manifest = half / "evaluation.json"
    manifest.write_text(manifest.read_text().replace('"source": "', '"source": "not '))
    before = {path: path.stat().st_mtime_ns for path in half.rglob("*")}
    assert "another folder" in complaint(capfd, *words(half)[1:])
    assert {path: path.stat().st_mtime_ns for path in half.rglob("*")} == before


def test_a_full_disk_is_one_line_and_what_is_finished_is_kept(
    whole, tmp_path, monkeypatch, capfd, request
):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    out = shutil.copytree(whole, tmp_path / "full")
    before = {path: path.read_bytes() for path in recordings(out)}
    request.getfixturevalue("full_disk")
    words = ["--arms", "a=scripted+breaks", "--seed", "10004", "--out", str(out)]
    line = complaint(capfd, *words, begun=True)
    assert "File too large" in line
    assert "free some space and run the command again" in line
    assert {path: path.read_bytes() for path in recordings(out)} == before


@pytest.mark.slow
def test_killed_and_resumed_with_two_workers_it_ends_the_same(tmp_path):
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    process = subprocess.Popen(
        [sys.executable, "-m", "scenarios.cli", *words(killed, *PAIR)], cwd=ROOT
    )
    while not list(killed.rglob("episodes/*.npz")):
        assert process.poll() is None
    process.kill()
    process.wait()
    assert main(words(killed, *PAIR, "--workers", "2")) == 0
    assert main(words(whole, *PAIR)) == 0
    assert told(killed) == told(whole)
