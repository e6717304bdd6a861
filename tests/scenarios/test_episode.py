"""Tests of the loop on real patients: who passes, what is counted, what an instruction stops."""

import json
import signal
import subprocess
import sys
import time
from dataclasses import replace
from itertools import groupby, islice, takewhile
from pathlib import Path

import numpy as np
import pytest

from controller.action import hold
from controller.driver import rig_in
from controller.holding import ControllerIdle
from planner.base import PLANNING_PERIOD_S
from planner.command import COMMANDS
from planner.instruction import CORRECTIONS, TASKS, Instruction
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.scripted import PlannerScripted
from scenarios.catalogue import CONTROLLERS, ORACLE, PolicyEntry
from scenarios.episode import STAYS_BACK_S, Episode
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import load
from scenarios.run_episode import begin, result_of, run_episode
from tests.scenarios.breaking_controller import BREAKS, BREAKS_AT_S
from tests.scenarios.procedures import run
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.outcome.nurse import EXCHANGE_S
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.sensing.exact import SenseExact
from tissue_sim.surgery.clip import detach
from tissue_sim.surgery.injury import Injury
from tissue_sim.thresholds import HELD_PINCH_N
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.world import World

ROOT = Path(__file__).parents[2]
SEED = 10_004
USUAL = CHOLECYSTECTOMY.tasks_with(textbook_from_seed(SEED).tubes)  # without a third tube
STAYS_BACK = round(STAYS_BACK_S / CONTROL_PERIOD_S)
ONE_STEP = 1.01 * CONTROL_PERIOD_S
LONG_CHUNK = 45  # longer than the planner's period of 30 steps


# --- a whole procedure ---


def test_the_expert_does_all_tasks_and_injures_nothing(procedure):
    assert procedure.result.error is None
    assert [task.success for task in procedure.result.tasks] == [True] * len(USUAL)
    assert procedure.result.injuries == ()
    assert procedure.result.success


def test_a_passed_procedure_tells_how_near_it_came_to_each_limit(procedure):
    peaks = {peak.event: peak for peak in procedure.result.peaks}
    assert not any(peak.breaks(1.0) for peak in peaks.values())
    assert {"pinch", "traction", "blunt force", "crush of duct", "stretch of artery"} < set(peaks)
    assert {"clip tilt", "lumen", "clip slip", "clip gap", "cuff", "clip hold"} < set(peaks)
    assert peaks["pinch"].value > HELD_PINCH_N  # it held the gallbladder


def test_each_task_has_its_entry_in_order(procedure):
    tasks = procedure.result.tasks
    assert [(task.index, task.instruction) for task in tasks] == [(t.index, t.text) for t in USUAL]
    assert all(task.time_s > 0 for task in tasks)


def test_the_tasks_were_asked_for_in_order_and_none_twice(procedure):
    asked = [task.index for task, _ in groupby(step.instruction.task for step in procedure.steps)]
    assert asked == [task.index for task in USUAL]


def test_no_command_leaps_also_not_before_or_after_a_tool_exchange(procedure):
    joints = np.stack([step.command.joints for step in procedure.steps])
    change = np.abs(np.diff(joints, axis=0)).reshape(-1, 7)
    assert change[:, 2].max() < 0.006  # insertion, m: 0.18 m/s
    assert np.delete(change, 2, axis=1).max() < 0.15  # rad: 4.5 rad/s


def test_exchange_time_is_counted_apart(procedure):
    result, steps = procedure.result, procedure.steps
    exchanging = sum(step.exchange for step in steps)
    n_exchanges = 1 + 3 + 1 + 3  # slim applier; a tube: two reloads, scissors; the applier again
    assert result.exchange_time_s == pytest.approx(n_exchanges * 2 * EXCHANGE_S)
    assert result.exchange_time_s == pytest.approx(exchanging * CONTROL_PERIOD_S)
    assert result.procedure_time_s == pytest.approx((len(steps) - exchanging) * CONTROL_PERIOD_S)
    assert result.procedure_time_s == pytest.approx(sum(task.time_s for task in result.tasks))


def test_observers_see_every_control_step_once(procedure):
    time_s = [step.time_s for step in procedure.steps]
    np.testing.assert_allclose(time_s, CONTROL_PERIOD_S * np.arange(1, len(time_s) + 1))
    np.testing.assert_array_equal(procedure.recording.arrays["time_s"], time_s)


@pytest.fixture
def finished(procedure):
    """Return the world of a finished procedure; the judge's pulls drew tissue after the tool."""
    world = procedure.world
    before, joints = world.state(), world.target
    for _ in range(5):
        joints[RIGHT_ARM, 2] -= 0.001
        world.step(JointCommand(joints=joints))
    yield world
    world.restore(before)


def test_a_new_planner_goes_through_a_finished_patient_task_by_task(finished):
    planner, observation = PlannerScripted(finished), finished.observe()
    said = [planner.plan(observation).task for _ in range(len(USUAL) + 2)]
    assert said == [*USUAL[1:], USUAL[-1], USUAL[-1], USUAL[-1]]


@pytest.mark.parametrize("harm", [None, "injury", "lost clip", "undone task"])
def test_harm_alone_fails_a_procedure(procedure, harm):
    world, tasks = procedure.world, {task.index: task for task in procedure.result.tasks}
    episode = begin_judging(world, tasks)
    before = world.state()
    try:
        if harm == "injury":
            bruise = Injury(event="pinch", time_s=1.0, value=40.0, limit=37.0)
            world.record = replace(world.record, injuries=(bruise,))
        elif harm == "lost clip":  # the second still closes the stump, so nothing leaks
            first, *others = world.record.clips
            world.record = replace(world.record, clips=(detach(world.tubes, first), *others))
        elif harm == "undone task":
            episode.tasks.results[5] = replace(episode.tasks.results[5], success=False)
        assert result_of(episode, 0.0).success == (harm is None)
    finally:
        world.restore(before)


@pytest.mark.parametrize("said", [True, False])
def test_a_done_task_counts_whether_it_was_asked_for_or_not(procedure, finished, said):
    tasks = {task.index: task for task in procedure.result.tasks if said or task.index != 16}
    episode = saying_the_last(finished, tasks)
    assert len(list(islice(episode.steps(), 2 * STAYS_BACK))) == STAYS_BACK + 1
    assert episode.tasks.is_complete


def test_an_episode_ends_when_nothing_is_left_to_cut_well_or_badly(procedure, finished):
    tasks = {task.index: task for task in procedure.result.tasks}
    tasks[6] = replace(tasks[6], success=False)  # one clip of three is gone
    finished.record = replace(finished.record, clips=finished.record.clips[1:])
    episode = saying_the_last(finished, tasks)
    assert len(list(islice(episode.steps(), 2 * STAYS_BACK))) == STAYS_BACK + 1
    assert not episode.tasks.is_complete


def test_the_last_task_alone_is_not_the_end():
    untouched = World()
    untouched.reset(textbook_from_seed(SEED))
    episode = saying_the_last(untouched, {})
    assert len(list(islice(episode.steps(), 10))) == 10
    assert not episode.tasks.is_complete


def saying_the_last(world, tasks):
    return begin_judging(world, tasks, PlannerSays(Instruction(task=USUAL[-1])))


def begin_judging(world, tasks, planner=None):
    episode = Episode(
        config=EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED),
        world=world,
        planner=planner or PlannerScripted(world),
        controller=ControllerIdle(PolicySetup(seed=SEED)),
        sense=SenseExact(),
        observation=world.observe(),
    )
    episode.tasks.results.update(tasks)
    return episode


# --- who fails, and what is an error ---


def test_the_idle_controller_fails_at_the_first_task_and_it_is_no_error():
    result = run_episode(
        EpisodeConfig(
            planner="scripted", scenario="textbook", seed=SEED, controller="idle", task_cap_s=2.0
        )
    )
    assert not result.success
    assert result.error is None
    assert [(task.index, task.success) for task in result.tasks] == [(1, False)]
    assert result.tasks[0].time_s == pytest.approx(2.0, abs=ONE_STEP)


@pytest.mark.parametrize("cap_s", [0.0, -1.0, float("nan"), float("inf"), "3", True])
def test_a_cap_that_is_no_time_is_refused(cap_s):
    with pytest.raises(ValueError, match="task_cap_s must be a number above 0"):
        EpisodeConfig(**ORACLE, task_cap_s=cap_s)


@pytest.mark.parametrize(
    ("choice", "told"),
    [
        ({"seed": True}, "seed must be a whole number of at least 0, got True"),
        ({"seed": 1.0}, "seed must be a whole number"),
        ({"cameras": "wrist_left"}, "cameras must be a tuple of names, got 'wrist_left'"),
        ({"scenario": "breathing", "magnitude": "3"}, "magnitude must be a number, got '3'"),
    ],
)
def test_a_choice_of_another_kind_is_refused(choice, told):
    with pytest.raises(ValueError, match=told):
        EpisodeConfig(**choice)


def test_a_seed_of_numpy_is_a_seed():
    seed = EpisodeConfig(seed=np.int64(5)).seed
    assert (seed, type(seed)) == (5, int)


def test_an_exception_is_an_error_and_keeps_its_trace_and_record(tmp_path, monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    result = attempt_episode(
        EpisodeConfig(planner="scripted", scenario="textbook", seed=SEED, controller="breaks"),
        tmp_path,
    ).result
    assert result.error == "RuntimeError: a string snapped"
    assert not result.success
    assert "breaking_controller.py" in (tmp_path / "errors" / f"{SEED}.txt").read_text()
    recording = load(tmp_path / "episodes" / f"{SEED}.npz")
    assert recording.error == result.error
    assert recording.arrays["time_s"][-1] == pytest.approx(BREAKS_AT_S, abs=ONE_STEP)


def test_the_trace_of_an_error_does_not_outlast_it(tmp_path):
    trace = tmp_path / "errors" / f"{SEED}.txt"
    trace.parent.mkdir()
    trace.write_text("of an earlier call")
    config = EpisodeConfig(planner="scripted", controller="idle", seed=SEED, task_cap_s=0.2)
    assert attempt_episode(config, tmp_path).result.error is None
    assert not trace.exists()


def test_an_exception_is_an_error_also_where_its_trace_finds_no_room(tmp_path, monkeypatch):
    def no_room(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("scenarios.recording.attempt.write_atomic", no_room)
    config = EpisodeConfig(planner="scripted", controller=BREAKS, scenario="textbook", seed=SEED)
    assert attempt_episode(config, tmp_path).result.error == "RuntimeError: a string snapped"


RUN_WITH_A_BREAKING_CONTROLLER = f"""
import signal, sys
from scenarios.catalogue import CONTROLLERS, PolicyEntry
CONTROLLERS["breaks"] = PolicyEntry(factory="{BREAKS}")
from scenarios.cli import main
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
sys.exit(main())
"""


def test_ctrl_c_keeps_the_finished_episodes(tmp_path):
    words = f"run --scenario textbook --controller breaks --seed {SEED} --episodes 3".split()
    words += ["--out", str(tmp_path)]
    program = subprocess.Popen(
        [sys.executable, "-c", RUN_WITH_A_BREAKING_CONTROLLER, *words],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        while not _finished_seeds(tmp_path) and program.poll() is None:
            time.sleep(0.05)
        time.sleep(1.0)  # into the second episode, which would hold still for 90 s
        program.send_signal(signal.SIGINT)
        out, err = program.communicate(timeout=60)
    finally:
        program.kill()
    assert program.returncode == 130, err
    assert _finished_seeds(tmp_path) == [SEED]
    assert f"seed {SEED} ended in error: RuntimeError: a string snapped" in out
    assert "Traceback" not in err
    assert load(tmp_path / "episodes" / f"{SEED + 1}.npz").error == "KeyboardInterrupt"


def _finished_seeds(out):
    results = out / "results.json"
    if not results.exists():
        return []
    return [episode["seed"] for episode in json.loads(results.read_text())["episodes"]]


# --- what stops a chunk ---


class PlannerSays:
    """Answers with one of these instructions for each call; the last one stays."""

    def __init__(self, *instructions):
        self._instructions = list(instructions)
        self.asked = 0

    def reset(self):
        pass

    hears_of_success = False

    def plan(self, observation):
        self.asked += 1
        return self._instructions.pop(0) if len(self._instructions) > 1 else self._instructions[0]


class ControllerCounts:
    """Gives long chunks that hold still; the jaw angle tells which chunk is played."""

    def __init__(self, length=LONG_CHUNK):
        self.length = length
        self.heard = []  # one instruction for each chunk
        self.resets = 0

    def reset(self):
        self.resets += 1

    def act(self, observation, instruction):
        self.heard.append(instruction.text)
        return self.length * (hold(np.full(2, jaw_of(len(self.heard)))),)


class ControllerGives(ControllerCounts):
    """Answers with the same each time."""

    def __init__(self, chunk):
        super().__init__()
        self._chunk = chunk

    def act(self, observation, instruction):
        return self._chunk


def jaw_of(chunk):
    return 0.3 + 0.01 * chunk


def chunks(steps):
    """Return the number of each chunk with how many steps it was played; 0 is the nurse's."""
    jaws = [0 if s.exchange else round((s.command.joints[0, 6] - 0.3) / 0.01) for s in steps]
    return [(chunk, len(list(group))) for chunk, group in groupby(jaws)]


def episode_of(planner, controller):
    return begin(
        EpisodeConfig(scenario="textbook", seed=SEED), planner=planner, controller=controller
    )


def test_the_same_instruction_lets_the_chunk_run_to_its_end():
    episode = episode_of(PlannerSays(Instruction(task=TASKS[0])), ControllerCounts())
    assert chunks(islice(episode.steps(), LONG_CHUNK + 5)) == [(1, LONG_CHUNK), (2, 5)]


def test_a_new_instruction_drops_the_running_chunk_at_once():
    first = Instruction(task=TASKS[0])
    second = Instruction(task=TASKS[0], correction=CORRECTIONS[0])
    controller = ControllerCounts()
    episode = episode_of(PlannerSays(first, second), controller)
    period = round(PLANNING_PERIOD_S / CONTROL_PERIOD_S)
    assert chunks(islice(episode.steps(), period + 5)) == [(1, period), (2, 5)]
    assert controller.heard == [first.text, second.text]


def test_a_persons_instruction_drops_the_running_chunk_and_the_planner_is_asked_on_time():
    planner, controller = PlannerSays(Instruction(task=TASKS[0])), ControllerCounts()
    episode = episode_of(planner, controller)
    steps = episode.steps()
    before = list(islice(steps, 10))
    higher = "move right arm higher"  # the left jaws, which count the chunks, are the controller's
    episode.inbox.press(COMMANDS[higher])
    (first, lasted), (second, corrected), (third, _) = chunks([*before, *islice(steps, 50)])
    assert (first, second, third, lasted) == (1, 2, 3, 10)
    assert corrected < LONG_CHUNK  # its distance was gone before
    assert controller.heard == [TASKS[0].text, higher, TASKS[0].text]
    assert planner.asked == 2


@pytest.mark.parametrize(("first", "then"), [(2, 4), (4, 2)], ids=["a later", "an earlier"])
def test_an_undone_task_counts_when_it_is_done_under_another_instruction(first, then):
    clip, back, back_again = (Instruction(task=TASKS[k]) for k in (1, first, then))
    planner = PlannerSays(*3 * [clip], back, back_again)
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED), planner=planner)
    left_undone = False
    for step in islice(episode.steps(), round(10.0 / CONTROL_PERIOD_S)):
        if step.instruction.task == back_again.task:
            left_undone |= not episode.tasks.results[back.task.index].success
            if step.outcome.task_done:
                break
    assert left_undone
    assert episode.tasks.results[back.task.index].success


class PlannerOneByOne:
    """Answers with the first task, then the second, and so on, from each reset on."""

    def __init__(self):
        self.reset()

    def reset(self):
        self._asked = 0

    def plan(self, observation):
        self._asked += 1
        return Instruction(task=TASKS[self._asked - 1])


def test_policies_that_have_run_before_begin_an_episode_anew():
    planner, controller = PlannerOneByOne(), ControllerCounts()
    for _ in range(2):
        (step,) = islice(episode_of(planner, controller).steps(), 1)
        assert step.instruction.task == TASKS[0]
    assert controller.resets == 2


def test_an_exchange_drops_the_chunk_and_resets_the_controller():
    clip, cut = Instruction(task=TASKS[1]), Instruction(task=TASKS[7])
    controller = ControllerCounts()
    episode = episode_of(PlannerSays(clip, cut), controller)
    period, exchange = (
        round(PLANNING_PERIOD_S / CONTROL_PERIOD_S),
        round(2 * EXCHANGE_S / CONTROL_PERIOD_S),
    )
    steps = list(islice(episode.steps(), period + exchange + 5))
    assert chunks(steps) == [(1, period), (0, exchange), (2, 5)]
    assert controller.resets == 2  # at the start, and after the exchange
    assert steps[-1].observation.tools[RIGHT_ARM] == "scissors"
    assert 1 not in episode.tasks.results  # a cut's time does not include the exchange
    assert episode.tasks.results[8].time_s == pytest.approx(5 * CONTROL_PERIOD_S)


def test_a_reload_drops_the_chunk_under_the_same_instruction_too():
    controller = ControllerCounts()
    episode = episode_of(PlannerSays(Instruction(task=TASKS[1])), controller)
    steps = episode.steps()
    before = list(islice(steps, 10))
    episode.world.record = replace(episode.world.record, clip_loaded=False)  # the clip fell out
    exchange = round(2 * EXCHANGE_S / CONTROL_PERIOD_S)
    after = list(islice(steps, exchange + 5))
    assert chunks([*before, *after]) == [(1, 11), (0, exchange), (2, 4)]  # seen a step later
    assert controller.resets == 2  # at the start, and after the exchange
    assert after[-1].observation.clip_loaded


def test_an_exchange_with_a_bent_wrist_ends_and_goes_on_in_the_home_pose():
    """Take a wrist that is bent farther than the new tool's goes."""
    episode = episode_of(PlannerSays(Instruction(task=TASKS[1])), ControllerCounts())
    world = episode.world
    world.equip("scissors")
    joints = world.arms.joints
    joints[RIGHT_ARM, 2], joints[RIGHT_ARM, 5] = 0.06, 1.39  # clear of the tubes
    for _ in range(20):
        world.step(JointCommand(joints=joints), intended=None)
    episode.guarded_driver.driver.attach(rig_in(world), joints)
    episode.observation = world.observe()
    exchange = round(2 * EXCHANGE_S / CONTROL_PERIOD_S)
    steps = list(islice(episode.steps(), exchange + 5))
    assert [step.exchange for step in steps] == [True] * exchange + [False] * 5
    for step in steps[-5:]:
        np.testing.assert_allclose(step.command.joints[RIGHT_ARM, :6], HOME_JOINTS[:6], atol=1e-9)
    assert not world.record.injuries


@pytest.mark.parametrize(
    ("planner", "controller", "told"),
    [
        (PlannerSays("cut it"), ControllerCounts(), "plan returned a str, not an Instruction"),
        (PlannerSays(Instruction(task=3)), ControllerCounts(), "the task 3, not a Task"),
        (None, ControllerGives(None), "act returned a NoneType, not a tuple of ToolActions"),
        (None, ControllerGives(hold(np.zeros(2))), "act returned a ToolAction, not a tuple"),
        (None, ControllerGives(np.zeros((8, 20))), "act returned a ndarray, not a tuple"),
        (None, ControllerGives(((0.0, 0.0),)), "act returned a tuple among its ToolActions"),
    ],
)
def test_a_policy_that_returns_something_else_is_told_so(planner, controller, told):
    episode = episode_of(planner or PlannerSays(Instruction(task=TASKS[0])), controller)
    with pytest.raises(TypeError, match=told):
        next(episode.steps())


def test_a_planners_task_that_nobody_can_carry_out_is_told_before_the_nurse_comes():
    by_scissors = replace(TASKS[1], right_tool="scissors")
    episode = episode_of(PlannerSays(Instruction(task=by_scissors)), ControllerCounts())
    with pytest.raises(ValueError, match="nobody can carry out: to clip, it needs a tube"):
        next(episode.steps())


def test_a_controller_without_an_action_gets_a_clear_error():
    episode = episode_of(PlannerSays(Instruction(task=TASKS[0])), ControllerCounts(length=0))
    with pytest.raises(ValueError, match="controller: a chunk must hold at least one action"):
        next(episode.steps())


# --- what follows from what ---


def test_a_clip_closed_in_the_air_is_reloaded_and_the_task_done():
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=SEED))
    joints = episode.guarded_driver.driver.joints
    for jaw_rad in (0.35, -0.1):
        joints[RIGHT_ARM, 6] = jaw_rad
        for _ in range(10):
            episode.world.step(JointCommand(joints=joints), intended="duct")
    assert not episode.world.record.clip_loaded
    assert [clip.crossings for clip in episode.world.record.clips] == [()]
    steps = list(takewhile(lambda step: 2 not in done(episode), episode.steps()))
    assert any(step.exchange for step in steps)
    assert done(episode) == {1, 2}
    assert len(episode.world.record.clips) == 2


def done(episode):
    return {task.index for task in episode.tasks.results.values() if task.success}


def test_the_same_seed_gives_the_same_recording_bit_for_bit(tmp_path):
    once, again, other = (
        run(
            EpisodeConfig(**ORACLE, scenario="textbook", seed=seed, task_cap_s=3.0),
            tmp_path / name,
        ).recording
        for name, seed in (("once", SEED), ("again", SEED), ("other", SEED + 1))
    )
    assert once.arrays["forces_n"].any()
    for name, array in once.arrays.items():
        np.testing.assert_array_equal(array, again.arrays[name])
    assert not np.array_equal(once.arrays["tips_endoscope"], other.arrays["tips_endoscope"])
