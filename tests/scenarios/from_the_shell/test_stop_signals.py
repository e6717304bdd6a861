"""Tests of signals: a stopped command keeps what it has, says so, and leaves nothing running."""

import json
import os
import signal
import subprocess
import time

import pytest

from scenarios.bench.trials.calot_process import CalotProcess, wait_until
from scenarios.recording.recorder import load
from tests.slow import slow

IDLE = ["--planner", "scripted", "--controller", "idle", "--scenario", "textbook"]
THREE = ["--seed", "10000", "--episodes", "3", "--out", "out"]
CALLED = [*IDLE[:-1], "short-tubes", "--magnitude", "1", *THREE]
RUN = ["run", *IDLE, "--seed", "10004", "--episodes", "3", "--out", "out"]
GRACE_S = 10.0


def recorded(process):
    return sorted((process.folder / "out").rglob("*.npz"))


def wait_until_episodes_run(process, n=1):
    """Wait until that many processes have begun an episode, which loads the simulator."""

    def simulating(pid):
        try:
            with open(f"/proc/{pid}/maps", encoding="utf-8") as file:
                return "libwarp" in (mapped := file.read()) or "warp-clang" in mapped
        except OSError:
            return False

    wait_until(lambda: not process.is_running or sum(map(simulating, process.processes())) >= n)
    time.sleep(3.0)  # into the episode


def stopped(process, number):
    """Return what the command writes and leaves after a signal; check what holds for all."""
    code, out, err = process.end()
    assert code == 128 + number, err
    assert process.left_running(0.5) == []
    assert list(process.temporary.iterdir()) == []
    assert "Traceback" not in err
    assert not list(process.folder.rglob(".*.lock"))
    return out


@pytest.mark.parametrize(("workers", "number"), [slow(1, signal.SIGHUP), (2, signal.SIGTERM)])
def test_a_stopped_run_keeps_what_broke_off(tmp_path, workers, number):
    with CalotProcess(words=[*RUN, "--workers", str(workers)], folder=tmp_path) as process:
        wait_until_episodes_run(process, workers)
        os.kill(process.pid, number)
        out = stopped(process, number)
    assert "interrupted after 0 of 3 episodes" in out
    assert len(recorded(process)) == workers
    for file in recorded(process):
        recording = load(file)
        assert (recording.result, recording.error) == (None, "KeyboardInterrupt")
        assert len(recording.arrays["time_s"]) > 0


@pytest.mark.slow
def test_further_signals_wait_for_what_is_being_saved(tmp_path):
    with CalotProcess(words=[*RUN, "--workers", "2"], folder=tmp_path) as process:
        wait_until_episodes_run(process, 2)
        for number in (signal.SIGTERM, *40 * (signal.SIGINT, signal.SIGTERM)):
            if process.is_running:
                os.kill(process.pid, number)
                time.sleep(0.02)
        assert "interrupted after 0 of 3" in stopped(process, signal.SIGTERM)
    assert [load(file).error for file in recorded(process)] == 2 * ["KeyboardInterrupt"]


@pytest.mark.slow
def test_nobody_outlives_a_killed_parent_and_what_broke_off_is_kept(tmp_path):
    with CalotProcess(words=[*RUN, "--workers", "2"], folder=tmp_path) as process:
        wait_until_episodes_run(process, 2)
        os.kill(process.pid, signal.SIGKILL)
        assert process.left_running(GRACE_S) == []
        assert list(process.temporary.iterdir()) == []
    assert [load(file).error for file in recorded(process)] == 2 * ["KeyboardInterrupt"]
    assert json.loads((tmp_path / "out/results.json").read_text())["episodes"] == []


class StartsAProcess:
    """A controller that starts a process, and then waits for ever."""

    def __init__(self, setup):
        del setup
        self._process = subprocess.Popen(["sleep", "1000"])

    def reset(self):
        pass

    def act(self, observation, instruction):
        self._process.wait()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL], ids=str)
@pytest.mark.slow
def test_processes_that_a_policy_starts_end_with_it(tmp_path, number):
    words = [*RUN, "--workers", "2", "--controller", f"{__name__}:StartsAProcess"]
    with CalotProcess(words=words, folder=tmp_path) as process:
        wait_until(lambda: len(process.processes()) >= 6)  # 2 workers, 2 children, a tracker
        os.kill(process.pid, number)
        if number != signal.SIGKILL:
            stopped(process, number)
        assert process.left_running(GRACE_S) == []


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=str)
@pytest.mark.parametrize(
    "words",
    [
        ["evaluate", "--arms", "a=scripted+idle", "--suite", "textbook", "--workers", "2"],
        ["collect", "--episodes", "4", "--workers", "2"],
        ["bench", "robustness", "--workers", "2"],
        ["view", *IDLE, "--start"],
    ],
    ids=lambda words: words[0],
)
def test_every_command_ends_with_the_signals_code_and_nothing_running(tmp_path, words, number):
    if words[0] != "bench":
        words = [*words, "--out", "out"]
    with CalotProcess(words=words, folder=tmp_path) as process:
        wait_until_episodes_run(process, 2 if "--workers" in words else 1)
        os.kill(process.pid, number)
        stopped(process, number)
    if words[0] in ("evaluate", "view"):
        assert {load(file).error for file in recorded(process)} == {"KeyboardInterrupt"}


@pytest.mark.slow
def test_a_run_that_ignores_the_end_of_its_session_goes_on(tmp_path):
    words = ["run", *CALLED[:-6], "--out", "out"]
    with CalotProcess(words=words, folder=tmp_path, ignores=(signal.SIGHUP,)) as process:
        wait_until_episodes_run(process)
        os.kill(process.pid, signal.SIGHUP)
        code, out, _ = process.end()
    assert code == 0
    assert "1 called for a person" in out


def test_a_run_whose_folder_vanishes_loses_no_result(tmp_path):
    results = tmp_path / "out/results.json"
    with CalotProcess(words=["run", *CALLED], folder=tmp_path) as process:
        wait_until(lambda: not process.is_running or len(recorded(process)) > 0)
        (tmp_path / "out").rename(tmp_path / "gone")
        assert process.end()[0] == 0
    assert len(json.loads(results.read_text())["episodes"]) == 3


@pytest.mark.slow
def test_an_evaluation_whose_folder_vanishes_reports_all_and_can_go_on(tmp_path):
    calls = "a=tests.scenarios.calling:PlannerCalls+idle"
    words = ["evaluate", "--arms", calls, "--suite", "textbook", *THREE]
    with CalotProcess(words=words, folder=tmp_path) as process:
        wait_until(lambda: not process.is_running or len(recorded(process)) > 0)
        (tmp_path / "out").rename(tmp_path / "gone")
        code, _, err = process.end()
    assert code == 0, err
    assert "Traceback" not in err
    kept = {file: file.stat().st_mtime_ns for file in recorded(process)}
    assert len(kept) < 3
    with CalotProcess(words=words, folder=tmp_path) as process:
        code, _, err = process.end()
    assert code == 0, err
    assert len(recorded(process)) == 3
    assert {file: file.stat().st_mtime_ns for file in kept} == kept
