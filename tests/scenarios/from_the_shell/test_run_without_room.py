"""Tests of `calot run` on a full disk: one line, exit code 2, and what is finished is told."""

from dataclasses import replace

import pytest

from scenarios.cli import main
from scenarios.commands import run
from scenarios.recording.attempt import Attempt
from tests.scenarios.breaking_controller import BREAKS
from tests.scenarios.example_results import PASSED, read_results
from tests.slow import slow

IDLE = ["run", "--controller", "idle", "--planner", "scripted"]


def test_what_was_finished_before_is_reported_and_kept(tmp_path, monkeypatch, capfd):
    tried = iter((Attempt(result=PASSED), Attempt(result=PASSED, unwritable="2.npz: no room")))
    monkeypatch.setattr(run, "attempt_episode", lambda *_: next(tried))
    assert main([*IDLE, "--episodes", "3", "--out", str(tmp_path)]) == 2
    out, err = capfd.readouterr()
    assert "passed 1 of 1" in out
    assert err.splitlines()[-1].startswith("calot: --out: cannot write 2.npz: no room; finished")
    assert read_results(tmp_path / "results.json") == (PASSED,)


def test_results_that_find_no_room_are_one_line(tmp_path, monkeypatch, capsys, request):
    long = replace(PASSED, tasks=20 * PASSED.tasks)
    monkeypatch.setattr(run, "attempt_episode", lambda *_: Attempt(result=long))
    request.getfixturevalue("full_disk")
    assert main([*IDLE, "--out", str(tmp_path)]) == 2
    _, err = capsys.readouterr()
    assert "Traceback" not in err
    assert f"cannot write {tmp_path / 'results.json'}: File too large" in err.splitlines()[-1]


@pytest.mark.parametrize("workers", [slow("1"), "2"])
def test_a_recording_that_finds_no_room_is_one_line(tmp_path, monkeypatch, capfd, request, workers):
    monkeypatch.setattr(run, "write_results", lambda *_, **__: None)  # as if it had room
    request.getfixturevalue("full_disk")
    words = ["run", "--controller", BREAKS, "--planner", "scripted", "--seed", "10004"]
    assert main([*words, "--workers", workers, "--out", str(tmp_path)]) == 2
    _, err = capfd.readouterr()
    assert "Traceback" not in err
    recording = tmp_path / "episodes" / "10004.npz"
    assert f"cannot write {recording}: OSError: [Errno 27] File too large" in err.splitlines()[-1]


def test_a_recording_of_before_is_no_recording_of_now_and_is_kept(tmp_path, capfd, request):
    recording = tmp_path / "episodes" / "10004.npz"
    recording.parent.mkdir()
    recording.write_bytes(b"a run before")
    request.getfixturevalue("full_disk")
    words = ["run", "--controller", BREAKS, "--planner", "scripted", "--seed", "10004"]
    assert main([*words, "--out", str(tmp_path)]) == 2
    assert f"cannot write {recording}: OSError" in capfd.readouterr().err.splitlines()[-1]
    assert recording.read_bytes() == b"a run before"
