"""Tests of policies by name: an outside policy gets only what a real robot could know."""

import pytest

from controller.action import hold
from planner.instruction import TASKS, Instruction
from planner.policy_setup import PolicySetup, is_privileged, privileged
from scenarios.catalogue import CONTROLLERS, ORACLE, PLANNERS
from scenarios.cli import main
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.policies import make_controller, make_planner, reads_hidden_state
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import load
from scenarios.run_episode import run_episode
from tests.scenarios.example_results import read_results
from tests.worlds import textbook_world

SEED = 10_002
HERE = "tests.scenarios.loop.test_policies"


class Still:
    """Holds both arms still, and keeps the arguments of its factory."""

    def __init__(self, *given):
        self.given = given

    def reset(self):
        pass

    def act(self, observation, instruction):
        return (hold(observation.joints[:, 6]),)


class FirstTask:
    """Answers with the first task at every call."""

    def __init__(self, *given):
        self.given = given

    def reset(self):
        pass

    def plan(self, observation):
        return Instruction(task=TASKS[0], time_s=observation.time_s)


@privileged
def still_that_knows(setup, world):
    return Still(setup, world)


@pytest.fixture(scope="module")
def world():
    return textbook_world(SEED)


def test_an_outside_factory_gets_the_setup_alone(world):
    config = EpisodeConfig(
        seed=SEED, planner=f"{HERE}:FirstTask", controller=f"{HERE}:Still", checkpoint="mine.bin"
    )
    controller = make_controller(config, world)
    assert controller.given == (PolicySetup(seed=SEED, checkpoint="mine.bin"),)
    assert make_planner(config, world).given == (PolicySetup(seed=SEED),)
    assert not is_privileged(controller)


def test_only_a_factory_that_declares_itself_privileged_gets_the_world(world):
    config = EpisodeConfig(scenario="textbook", seed=SEED, controller=f"{HERE}:still_that_knows")
    controller = make_controller(config, world)
    assert controller.given == (PolicySetup(seed=SEED), world)
    assert is_privileged(controller)


def test_among_calots_policies_only_the_oracle_reads_the_hidden_state():
    own = {name for name in PLANNERS | CONTROLLERS if reads_hidden_state(name)}
    assert own == {ORACLE["planner"], ORACLE["controller"]}


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("nowhere.at_all:Thing", "No module named"),
        (f"{HERE}:Missing", "Missing"),
        (f"{HERE}:SEED", "it is a int, not a factory"),
        (f"{HERE}:FirstTask", "has no act"),
    ],
)
def test_a_name_that_makes_no_controller_is_refused(world, name, said):
    with pytest.raises(ValueError, match=said):
        make_controller(EpisodeConfig(scenario="textbook", seed=SEED, controller=name), world)


def test_objects_take_the_place_of_names_and_the_result_names_them():
    config = EpisodeConfig(scenario="textbook", seed=SEED, task_cap_s=0.5)
    result = run_episode(config, planner=FirstTask(), controller=Still())
    assert (result.planner, result.controller) == (f"{HERE}:FirstTask", f"{HERE}:Still")
    assert (result.sense, result.privileged) == ("tracked", ())


def test_the_oracle_is_named_privileged_in_the_result():
    result = run_episode(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED, task_cap_s=0.2))
    assert result.privileged == ("planner", "controller")


def test_a_recording_of_outside_policies_can_be_verified(tmp_path):
    config = EpisodeConfig(
        seed=SEED, planner=f"{HERE}:FirstTask", controller=f"{HERE}:Still", task_cap_s=0.5
    )
    attempt_episode(config, tmp_path)
    file = tmp_path / "episodes" / f"{SEED}.npz"
    assert load(file).config["controller"] == f"{HERE}:Still"
    named = ["--planner", f"{HERE}:FirstTask", "--controller", f"{HERE}:Still"]
    assert main(["replay", "--verify", str(file), *named]) == 0


def test_calot_run_finds_a_policy_in_the_users_folder(tmp_path, monkeypatch, capfd):
    (tmp_path / "my_still.py").write_text(
        "from controller.action import hold\n\n\n"
        "class Still:\n"
        "    def __init__(self, setup):\n        pass\n\n"
        "    def reset(self):\n        pass\n\n"
        "    def act(self, observation, instruction):\n"
        "        if observation.time_s > 0.5:\n            raise RuntimeError('enough')\n"
        "        return (hold(observation.joints[:, 6]),)\n"
    )
    monkeypatch.chdir(tmp_path)
    words = ["run", "--controller", "my_still:Still", "--seed", str(SEED), "--out", "out"]
    words += ["--scenario", "textbook"]
    assert main(words) == 3
    (result,) = read_results(tmp_path / "out" / "results.json")
    assert (result.planner, result.controller) == (EpisodeConfig.planner, "my_still:Still")
    said = capfd.readouterr().err
    assert "controller: my_still:Still" in said
    assert "sense: tracked" in said


def test_a_factory_that_is_not_there_is_one_clear_line(capfd, tmp_path):
    assert main(["run", "--controller", "nowhere:Thing", "--out", str(tmp_path)]) == 2
    (line,) = capfd.readouterr().err.strip().splitlines()
    assert "--controller nowhere:Thing" in line
