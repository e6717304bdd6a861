"""Tests of a rollout's labels: they name the right task and correction, not those given."""

from dataclasses import replace
from itertools import islice, takewhile

import numpy as np
import pytest

from controller.expert.skills import among_tissue
from controller.expert.targets import clip_pose
from planner.command import COMMANDS
from planner.correction import correction_from_text
from planner.instruction import TASKS, Instruction
from planner.procedure.outcomes import structure_of
from scenarios.bench.trials.obedience_trial import PlannerFixed
from scenarios.demonstration.demonstrate import begun
from scenarios.demonstration.demonstration_recorder import is_frame
from scenarios.demonstration.failures import PAST_M, FailureTracker
from scenarios.demonstration.mix import PlannedDemonstration
from scenarios.demonstration.rollout_recorder import RolloutRecorder
from scenarios.loop.person.guided_arm import GuidedArm
from tissue_sim.outcome.predicates import gallbladder_grasped, gallbladder_held, grasper_hooked
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

SEED, SLIPPING, ROOMY, DEEPER, HOOKING = 10_001, 10_003, 10_030, 10_000, 10_000
GRAB, FIRST_CLIP = TASKS[:2]
OPENED_BY, OUT_BY = 60, 240  # steps
WIDE_RAD = 1.17  # the expert's opening


def rolled_out(frames, planner=None):
    """Return the columns of an expert's rollout with a wrong grasp, and which frames were led."""
    kind = "recovery:grasp-missed-below"
    episode = begun(PlannedDemonstration(seed=SEED, kind=kind, noise=False))
    episode = replace(episode, planner=planner or episode.planner)
    recorder = RolloutRecorder(lambda: True)
    recorder.on_reset(episode.world)
    led = []
    for step in episode.steps():
        recorder.on_step(step)
        led += [step.asked is None] if is_frame(step) else []
        if len(led) == frames:
            break
    return recorder.columns(SEED, kind), np.array(led)


@pytest.fixture(scope="module")
def recovered():
    return rolled_out(400)


def test_a_planner_that_gives_the_right_task_agrees_with_the_labels(recovered):
    columns, _ = recovered
    said = [TASKS[k - 1].text for k in columns["task"]]
    assert said == columns["instruction"].tolist()
    assert set(said) >= {GRAB.text, FIRST_CLIP.text}


def test_nothing_of_it_is_imitated(recovered):
    assert not recovered[0]["expert"].any()


def test_a_mistake_is_labelled_with_drawing_back_until_it_is_undone(recovered):
    columns, led = recovered
    flag, after = columns["flag"], np.flatnonzero(led)[-1] + 1
    assert not flag[:after].any()
    undone = np.flatnonzero(flag)[-1] + 1
    assert flag[after:undone].all()  # also while the expert would pause
    assert after < undone < len(flag)
    wanted = {correction_from_text(text) for text in columns["correction"][flag]}
    assert {c.arm for c in wanted} == {"left"}
    assert wanted & {
        correction_from_text(t) for t in ("open left gripper", "move left arm towards me")
    }


def test_a_wrong_task_does_not_change_the_due_task():
    saying = PlannerFixed(instruction=Instruction(task=FIRST_CLIP))
    columns, _ = rolled_out(40, saying)
    assert set(columns["instruction"]) == {FIRST_CLIP.text}
    assert set(columns["task"]) == {GRAB.index}


def test_an_overshoot_lasts_while_the_applier_is_deeper_than_its_goal():
    episode = begun(PlannedDemonstration(seed=DEEPER, kind="recovery:overshoot", noise=False))
    failing, stood, deeper_m = FailureTracker(), [], []
    for step in islice(episode.steps(), 600):
        task, T = step.instruction.task, episode.world.arms.T_world_tool()[RIGHT_ARM]
        stood.append(failing.after(step, episode.world) and step.asked is not None)
        if stood[-1]:
            goal = clip_pose(episode.world, structure_of(task, episode.world), task.clip)
            deeper_m.append((T[:3, 3] - goal[:3, 3]) @ T[:3, 2])
        elif deeper_m:
            break
    assert any(stood)
    assert not stood[-1]
    assert min(deeper_m) >= PAST_M
    assert among_tissue(RIGHT_ARM, episode.world)


def test_a_slip_is_flagged_once_it_shows_until_the_grasper_is_out_of_the_tissue():
    kind = "recovery:grasp-slip"
    episode = begun(PlannedDemonstration(seed=ROOMY, kind=kind, noise=False))
    recorder = RolloutRecorder(lambda: True)
    recorder.on_reset(episode.world)
    held, among = [], []  # in the observation after each frame
    for step in episode.steps():
        recorder.on_step(step)
        if not step.exchange:
            held.append(gallbladder_held(episode.world))
            among.append(among_tissue(LEFT_ARM, episode.world))
        if True in held and not among[-1]:
            break
    flag = recorder.columns(ROOMY, kind)["flag"]
    lost = len(held) - held[::-1].index(True)  # the first frame after which it is not held
    assert not flag[: lost + 1].any()
    assert flag[lost + 1 :].all()
    assert among[lost]


@pytest.mark.slow
def test_every_slip_is_flagged_until_a_tube_is_cut_also_one_while_a_clip_is_loaded():
    episode = begun(PlannedDemonstration(seed=SLIPPING, kind="recovery:grasp-slip", noise=False))
    recorder = RolloutRecorder(lambda: True)
    recorder.on_reset(episode.world)
    slips = []  # for each slip: is it in an exchange, is it after a cut
    for step in episode.steps():
        recorder.on_step(step)
        slips += [(step.exchange, bool(episode.world.record.cuts)) for _ in step.applied]
    flag = recorder.columns(SLIPPING, "recovery:grasp-slip")["flag"]
    assert {True, False} == {cut for _, cut in slips}
    assert any(exchange for exchange, cut in slips if not cut)
    assert np.count_nonzero(flag[1:] & ~flag[:-1]) == sum(not cut for _, cut in slips)


def test_a_gallbladder_that_is_let_go_is_flagged_until_the_grasper_is_out():
    episode = begun(PlannedDemonstration(seed=SEED, kind="nominal:textbook", noise=False))
    world, steps, failing = episode.world, episode.steps(), FailureTracker()
    grasping = takewhile(lambda _: not gallbladder_grasped(world), steps)
    assert not any(failing.after(step, world) for step in grasping)
    episode.inbox.press(COMMANDS["open left gripper"])
    episode.inbox.say("yes")
    assert any(failing.after(step, world) for step in islice(steps, OPENED_BY))
    assert not gallbladder_held(world)
    episode.inbox.press(COMMANDS[GRAB.text])
    assert not all(failing.after(step, world) for step in islice(steps, OUT_BY))
    assert not among_tissue(LEFT_ARM, world)


def test_a_grasper_that_hooks_is_always_flagged():
    episode = begun(PlannedDemonstration(seed=HOOKING, kind="recovery:grasp-slip", noise=False))
    world, steps = episode.world, episode.steps()
    next(step for step in steps if gallbladder_held(world))
    next(step for step in steps if not gallbladder_held(world))
    here = world.arms.T_world_tool()[LEFT_ARM]
    episode.inbox.guided = GuidedArm(arm=LEFT_ARM, T_world_goal=here, jaw_rad=WIDE_RAD)
    opened = islice(steps, OPENED_BY)
    flags = [(FailureTracker().after(step, world), grasper_hooked(world)) for step in opened]
    assert set(flags) == {(False, False), (True, True)}
    assert among_tissue(LEFT_ARM, world)
