"""Tests of the scripted planner on a real patient: tasks in order, tried again, none left out."""

from dataclasses import replace

import pytest

from planner.base import PATIENCE_S
from planner.command import COMMANDS
from planner.instruction import TASKS
from planner.person.override import PlannerOverridden
from planner.procedure.outcomes import structure_of, task_done
from planner.scripted import MOST_TRIES, PlannerScripted
from scenarios.catalogue import ORACLE, SCENARIOS
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.perturbation import AtTask
from scenarios.run_episode import begin
from tests.tissue_sim.kinds import POLYMER, SLIM_APPLIER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.outcome.predicates import right_arm_back
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, JointCommand
from tissue_sim.tools.instruments import applier_for
from tissue_sim.world import World

GRAB, FIRST_CLIP, BACK_FROM_FIRST_CLIP, SECOND_CLIP = TASKS[:4]
OUT_INSERTION_M = 0.05


@pytest.fixture(scope="module")
def approach():
    """Return a world and two states: at the start, and grasped with the right arm at the tubes."""
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004))
    begun = episode.world.state()
    for step in episode.steps():
        if step.instruction.task == FIRST_CLIP and not right_arm_back(episode.world):
            break
    return episode.world, begun, episode.world.state()


@pytest.fixture
def untouched(approach):
    world, begun, _ = approach
    world.restore(begun)
    return world


@pytest.fixture
def at_the_tubes(approach):
    world, _, grasped = approach
    world.restore(grasped)
    return world


def ask(planner, world, after_s=0.0):
    """Return the task that the planner gives now, or `after_s` later in an unchanged world."""
    observation = world.observe()
    return planner.plan(replace(observation, time_s=observation.time_s + after_s)).task


def move_right_arm(world, *, insertion_m=None, jaw_rad=None, steps=30):
    joints = world.target
    start = joints[RIGHT_ARM].copy()
    for k in range(steps):
        share = (k + 1) / steps
        if insertion_m is not None:
            joints[RIGHT_ARM, 2] = start[2] + share * (insertion_m - start[2])
        if jaw_rad is not None:
            joints[RIGHT_ARM, 6] = start[6] + share * (jaw_rad - start[6])
        world.step(JointCommand(joints=joints), intended="duct")


def open_grasper(world):
    joints = world.target
    joints[LEFT_ARM, 6] = 1.0
    for _ in range(30):
        world.step(JointCommand(joints=joints))


def too_short_m(tube, diameter_m):
    """Return a length that is a hair too short for a clip on either side of a cut."""
    return needed_m(tube, applier_for(diameter_m), FEWEST_CLIPS) - 1e-6


def with_second_artery(length_m):
    two = variant("two-arteries", textbook_from_seed(10_004))
    return replace(two, second_artery=replace(two.second_artery, length_m=length_m))


def order_of(anatomy):
    """Return the tasks that the planner gives where each is over a second after it was given."""
    world = World()
    world.reset(anatomy)
    planner, said = PlannerScripted(world), []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("planner.scripted.task_over", lambda task, _: task in said)
        patch.setattr("planner.scripted.gallbladder_held", lambda _: True)
        for second in range(2 * len(TASKS)):
            said.append(ask(planner, world, float(second)))
    return [task.index for task in dict.fromkeys(said)]


def test_the_third_tubes_tasks_follow_the_17_where_there_is_a_second_artery():
    assert order_of(textbook_from_seed(10_004)) == list(range(1, 18))
    assert order_of(with_second_artery(0.025)) == list(range(1, 26))


def test_a_short_second_artery_gets_a_clip_on_either_side_of_the_cut():
    assert order_of(with_second_artery(needed_m("second artery", SLIM_APPLIER) - 1e-6)) == [
        *range(1, 20),
        *range(22, 26),
    ]


def test_a_task_stays_until_it_is_done(untouched):
    planner = PlannerScripted(untouched)
    for after_s in (0.0, 1.0, 5 * PATIENCE_S, 50 * PATIENCE_S):
        assert ask(planner, untouched, after_s) == GRAB


def test_the_next_task_follows_when_the_criterion_is_met(at_the_tubes):
    planner = PlannerScripted(at_the_tubes)
    assert task_done(GRAB, at_the_tubes)
    assert [ask(planner, at_the_tubes, k) for k in range(3)] == 3 * [FIRST_CLIP]


def test_a_clip_closed_in_the_air_does_not_complete_the_task(at_the_tubes):
    planner = PlannerScripted(at_the_tubes)
    ask(planner, at_the_tubes)
    move_right_arm(at_the_tubes, insertion_m=OUT_INSERTION_M, jaw_rad=0.35)
    move_right_arm(at_the_tubes, jaw_rad=-0.1, steps=15)
    (clip,) = at_the_tubes.record.clips
    assert clip.crossings == ()
    assert ask(planner, at_the_tubes) == FIRST_CLIP


def test_it_backs_off_after_its_patience_and_tries_again_once_the_arm_is_back(at_the_tubes):
    planner = PlannerScripted(at_the_tubes)
    assert ask(planner, at_the_tubes) == FIRST_CLIP
    assert ask(planner, at_the_tubes, PATIENCE_S - 0.1) == FIRST_CLIP
    assert ask(planner, at_the_tubes, PATIENCE_S + 0.1) == BACK_FROM_FIRST_CLIP
    assert ask(planner, at_the_tubes, 3 * PATIENCE_S) == BACK_FROM_FIRST_CLIP
    move_right_arm(at_the_tubes, insertion_m=OUT_INSERTION_M)
    assert right_arm_back(at_the_tubes)
    assert ask(planner, at_the_tubes, 4 * PATIENCE_S) == FIRST_CLIP
    assert ask(planner, at_the_tubes, 5 * PATIENCE_S - 0.1) == FIRST_CLIP  # the time starts again
    assert ask(planner, at_the_tubes, 5 * PATIENCE_S + 0.1) == BACK_FROM_FIRST_CLIP


def test_a_pause_does_not_count_as_a_try(at_the_tubes):
    observation = at_the_tubes.observe()
    planner = PlannerOverridden(PlannerScripted(at_the_tubes))
    planner.reset()
    start_s, said = observation.time_s, []
    for k, word in enumerate(["", "pause", *5 * [""], "resume", ""]):
        now = replace(observation, time_s=start_s + k * 0.4 * PATIENCE_S)
        if word:
            planner.instruct(COMMANDS[word], now)
        said.append(planner.plan(now).task)
    assert said == 9 * [FIRST_CLIP]


def test_a_task_that_has_failed_often_enough_is_left_to_a_person(at_the_tubes):
    planner = PlannerScripted(at_the_tubes)
    start_s, said = at_the_tubes.observe().time_s, []
    move_right_arm(at_the_tubes, insertion_m=OUT_INSERTION_M)
    for k in range(3 * MOST_TRIES):
        observation = replace(at_the_tubes.observe(), time_s=start_s + k * (PATIENCE_S + 0.1))
        said.append(planner.plan(observation))
    calls = [s for s in said if s.call]
    assert said[0].task == FIRST_CLIP
    assert calls[0].remark == f"{FIRST_CLIP.text!r} has failed {MOST_TRIES} times."
    tried = said[: said.index(calls[0])]
    assert [s.task for s in tried].count(BACK_FROM_FIRST_CLIP) == MOST_TRIES


def test_a_grab_that_slips_does_not_answer_for_the_clip_s_tries(at_the_tubes):
    """The grasper opens during the last of the clip's tries; the grab itself has not failed."""
    planner, start_s = PlannerScripted(at_the_tubes), at_the_tubes.observe().time_s
    move_right_arm(at_the_tubes, insertion_m=OUT_INSERTION_M)
    said = []
    for k in range(2 * MOST_TRIES):
        if k == 2 * MOST_TRIES - 1:
            open_grasper(at_the_tubes)
        observation = replace(at_the_tubes.observe(), time_s=start_s + k * (PATIENCE_S + 0.1))
        said.append(planner.plan(observation))
    assert not any(s.call for s in said)
    for second in (1.0, 2.0):
        after = planner.plan(replace(observation, time_s=said[-1].time_s + second))
        assert (after.task, after.call) == (GRAB, False)


def test_a_grab_that_does_not_succeed_is_left_to_a_person(untouched):
    planner, start = PlannerScripted(untouched), untouched.observe()
    for share, calls in ((0.0, False), (0.99, False), (1.01, True)):
        time_s = start.time_s + share * MOST_TRIES * PATIENCE_S
        said = planner.plan(replace(start, time_s=time_s))
        assert (said.task, said.call) == (GRAB, calls)
    assert said.remark == f"{GRAB.text!r} has not succeeded within 36 s."


def test_after_a_reset_it_starts_at_the_first_task(at_the_tubes, approach):
    planner = PlannerScripted(at_the_tubes)
    assert ask(planner, at_the_tubes) == FIRST_CLIP
    planner.reset()
    at_the_tubes.restore(approach[1])
    assert ask(planner, at_the_tubes) == GRAB


def test_after_a_slip_no_task_is_given_that_is_still_done():
    (slip,) = SCENARIOS["grasp-slip"].perturbations
    effects = Effects([replace(slip, at=AtTask(index=SECOND_CLIP.index))], seed=0)
    episode = begin(EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004), effects=effects)
    episode = replace(episode, planner=PlannerScripted(episode.world, hears_of_success=False))
    said = []
    for step in episode.steps():
        if not said or step.instruction.task != said[-1]:
            said += [step.instruction.task]
        if said.count(SECOND_CLIP) == 2:
            break
    back_from_second = TASKS[SECOND_CLIP.index]
    assert said == [*TASKS[:4], back_from_second, GRAB, SECOND_CLIP]


@pytest.mark.parametrize("change", ["short duct", "short artery", "short second artery"])
def test_it_calls_a_person_where_it_cannot_operate_but_not_after_a_clip(untouched, change):
    asked = untouched.anatomy
    hopeless = {
        "short duct": replace(asked, duct_length_m=too_short_m("duct", asked.duct_diameter_m)),
        "short artery": replace(
            asked, artery_length_m=too_short_m("artery", asked.artery_diameter_m)
        ),
        "short second artery": with_second_artery(too_short_m("second artery", 0.001)),
    }[change]
    world = World()
    world.reset(hopeless)
    planner = PlannerScripted(world)
    said = planner.plan(world.observe())
    assert (said.call, said.hold, said.remark) == (True, True, why_call(hopeless))
    middle_m = 0.5 * world.tubes.length_m["duct"]
    T = astride(world.tubes, "duct", middle_m, beyond_m=0.5 * POLYMER.length_m)
    world.record = replace(
        world.record, clips=(latch(world.tubes, T, POLYMER, number=1, time_s=0.0),)
    )
    assert not planner.plan(world.observe()).call


def test_an_instruction_carries_the_time_it_was_given(untouched):
    observation = replace(untouched.observe(), time_s=7.5)
    said = PlannerScripted(untouched).plan(observation)
    assert (said.time_s, said.source, said.correction) == (7.5, "planner", None)


def test_a_tube_in_two_parts_is_not_cut_again_though_it_had_no_clips(at_the_tubes):
    cut, back = TASKS[7:9]
    planner = PlannerScripted(at_the_tubes, order=(cut, back))
    assert ask(planner, at_the_tubes) == cut
    tube = structure_of(cut, at_the_tubes)
    middle_m = 0.5 * at_the_tubes.tubes.length_m[tube]
    T = astride(at_the_tubes.tubes, tube, middle_m, beyond_m=BLADE_LENGTH_M / 2)
    made = sever(at_the_tubes.tubes, T, time_s=at_the_tubes.record.time_s)
    at_the_tubes.record = replace(at_the_tubes.record, cuts=tuple(made))
    assert at_the_tubes.tubes.in_two_parts(tube)
    assert not task_done(cut, at_the_tubes)
    assert ask(planner, at_the_tubes) == back
    assert ask(planner, at_the_tubes, 2 * PATIENCE_S) == back


@pytest.mark.parametrize("on_left", [False, True])
def test_the_duct_comes_before_an_artery_that_crosses_it(on_left):
    crossing = variant("artery-in-front", textbook_from_seed(10_004))
    usual = list(range(1, 18))
    duct_on_right = [1, *range(10, 18), *range(2, 10)]
    assert order_of(replace(crossing, artery_on_left=on_left)) == (
        duct_on_right if on_left else usual
    )
    assert order_of(replace(textbook_from_seed(10_004), artery_on_left=on_left)) == usual
