"""Tests of policies that end their process: codes 0 and 1 mean that every episode has a result."""

import asyncio
import json
import os
import sys
import time

import pytest

from controller.holding import ControllerIdle
from scenarios.cli import main
from scenarios.files.errors import ERROR
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from tests.scenarios.calling import PlannerCalls
from tests.scenarios.from_the_shell.complaint import complaint
from tests.slow import slow

SEED = 10_004
GRABS, CALLS = "tests.scenarios.calling:PlannerGrabs", "tests.scenarios.calling:PlannerCalls"
RUN = ["run", "--scenario", "textbook", "--seed", str(SEED), "--planner", GRABS]


class Leaves(ControllerIdle):
    """Asks Python to exit, as a library's check of a licence does."""

    def act(self, observation, instruction):
        sys.exit("no licence")


class Cancelled(ControllerIdle):
    def act(self, observation, instruction):
        raise asyncio.CancelledError("the loop is closed")


class Exits(ControllerIdle):
    def act(self, observation, instruction):
        os._exit(0)


class ExitsWithOne(ControllerIdle):
    def act(self, observation, instruction):
        os._exit(1)


class Aborts(ControllerIdle):
    def act(self, observation, instruction):
        os.abort()


class ExitsOnce(PlannerCalls):
    """Ends its process on the first of two seeds; calls for a person at once on the other."""

    def __init__(self, setup):
        self._exits = setup.seed == SEED

    def plan(self, observation):
        if self._exits:
            os._exit(0)
        return super().plan(observation)


class Slow(ControllerIdle):
    """Takes a fifth of a second for one motion."""

    def act(self, observation, instruction):
        time.sleep(0.2)
        return super().act(observation, instruction)[:1]


def episodes_in(out):
    return json.loads((out / "results.json").read_text())["episodes"]


@pytest.mark.parametrize(
    ("leaves", "why"),
    [
        ("Leaves", "SystemExit: no licence"),
        ("Cancelled", "CancelledError: the loop is closed"),
    ],
)
def test_an_exit_that_is_asked_for_is_an_error_with_its_traceback(leaves, why, tmp_path):
    config = EpisodeConfig(
        scenario="textbook", seed=SEED, planner=GRABS, controller=f"{__name__}:{leaves}"
    )
    result = attempt_episode(config, tmp_path).result
    assert (result.outcome, result.error) == ("error", why)
    assert "in act" in (tmp_path / "errors" / f"{SEED}.txt").read_text()


@pytest.mark.parametrize("leaves", ["Exits", *map(slow, ["ExitsWithOne", "Aborts", "Leaves"])])
def test_a_policy_that_ends_its_process_leaves_an_error(leaves, tmp_path, capfd):
    code = main([*RUN, "--controller", f"{__name__}:{leaves}", "--out", str(tmp_path)])
    assert code == ERROR
    (episode,) = episodes_in(tmp_path)
    assert episode["error"]
    assert f"seed {SEED} ended in error: {episode['error']}" in capfd.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", "evaluate"])
def test_and_the_other_episodes_go_on(command, tmp_path):
    words = {
        "run": ["--scenario", "textbook", "--planner", f"{__name__}:ExitsOnce"],
        "evaluate": ["--suite", "textbook", "--arms", f"mine={__name__}:ExitsOnce+idle"],
    }[command]
    controller = ["--controller", "idle"] if command == "run" else []
    seeds = ["--seed", str(SEED), "--episodes", "2", "--out", str(tmp_path)]
    assert main([command, *words, *controller, *seeds]) == ERROR
    if command == "run":
        first, second = episodes_in(tmp_path)
        assert "worker died with exit code 0" in first["error"]
        assert (second["error"], second["call"] is not None) == (None, True)


def test_a_module_that_exits_as_it_is_imported_is_refused(tmp_path, capfd, monkeypatch):
    (tmp_path / "leaving.py").write_text("import sys\nsys.exit(0)\n")
    monkeypatch.syspath_prepend(tmp_path)
    said = complaint(capfd, "run", "--controller", "leaving:make", "--out", str(tmp_path / "out"))
    assert "--controller leaving:make: SystemExit: 0 (leaving.py:2)" in said


@pytest.mark.slow
def test_a_slow_controller_is_told(tmp_path, capfd):
    words = ["run", "--scenario", "textbook", "--seed", str(SEED), "--planner", LATER]
    assert main([*words, "--controller", f"{__name__}:Slow", "--out", str(tmp_path)]) != ERROR
    (episode,) = episodes_in(tmp_path)
    assert episode["act"]["took_s"] >= 0.2
    assert episode["act"]["lasts_s"] == pytest.approx(1 / 30)
    told = f"seed {SEED}: the controller took at most {episode['act']['took_s']:.3f} s for motions"
    out, _ = capfd.readouterr()
    assert f"{told} that last 0.033 s: too slow for a robot" in out


LATER = f"{__name__}:CallsSoon"


class CallsSoon(PlannerCalls):
    """Has the robot act for a second before it calls for a person."""

    def plan(self, observation):
        from tests.scenarios.calling import PlannerGrabs

        grabs = observation.time_s < 0.5
        return PlannerGrabs.plan(self, observation) if grabs else super().plan(observation)


def test_one_that_is_slower_than_it_may_be_is_an_error(tmp_path, capfd):
    slow = ["--controller", f"{__name__}:Slow", "--act-limit", "0.1", "--out", str(tmp_path)]
    assert main([*RUN, *slow]) == ERROR
    assert "TooSlowError: controller: act took 0.2" in capfd.readouterr().out
    (episode,) = episodes_in(tmp_path)
    assert "s, more than the limit of 0.1 s" in episode["error"]


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf"])
def test_a_limit_that_is_none_is_refused(limit, capfd):
    assert "--act-limit" in complaint(capfd, *RUN, "--controller", "idle", "--act-limit", limit)
