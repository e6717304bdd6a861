"""Tests of a demonstration: the expert's frames are marked; failures are flagged until undone."""

from dataclasses import replace
from itertools import islice, takewhile

import numpy as np
import pytest

from controller.dataset.part import read_part
from controller.dataset.rollouts import rollout_of
from controller.dataset.schema import STATE, TISSUE
from controller.diffusion.policy import CHECKPOINTS, Policy
from controller.diffusion.training import PRESETS
from planner.correction import CORRECTIONS, correction_from_text
from planner.instruction import TASKS, Instruction
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import GRAB
from scenarios.demonstration.demonstrate import begun, demonstrate, part_path, run
from scenarios.demonstration.demonstration_recorder import DemonstrationRecorder
from scenarios.demonstration.interjections import PlannerInterjecting, is_harmless
from scenarios.demonstration.mix import PlannedDemonstration, demonstrations
from scenarios.demonstration.turns import expert_acts
from tests.scenarios.calling import PlannerCalls
from tissue_sim.outcome.room import why_call
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.sensing.observation import encoded_and_tissue

SEED, ROOMY = 10_001, 10_030
SEEN_TIPS = slice(14, 38)  # in what encoders tell: (2, 3, 4)


class Shown:
    """Holds the first frames of a demonstration and the steps that they come from."""

    def __init__(self, kind, frames, noise=True):
        self.episode = begun(PlannedDemonstration(seed=SEED, kind=kind, noise=noise))
        self.recorder = DemonstrationRecorder(lambda: expert_acts(self.episode.controller))
        self.recorder.on_reset(self.episode.world)
        self.first = self.episode.observation
        self.steps = []
        for step in islice(self.episode.steps(), frames):
            self.recorder.on_step(step)
            self.steps.append(step)
        self.columns = self.recorder.columns(SEED, kind)


@pytest.fixture(scope="module")
def nominal():
    return Shown("nominal:textbook", 500)


@pytest.fixture(scope="module")
def recovery():
    return Shown("recovery:grasp-missed-below", 400)


def test_a_frame_is_the_observation_before_the_action(nominal):
    seen = [nominal.first, *(step.observation for step in nominal.steps)]
    pairs = zip(nominal.steps, seen[:-1], strict=True)
    expected = [observation.vector() for step, observation in pairs if not step.exchange]
    state, tissue = encoded_and_tissue(np.stack(expected))
    np.testing.assert_array_equal(nominal.columns[STATE], state)
    np.testing.assert_array_equal(nominal.columns[TISSUE], tissue)


def test_under_noise_the_label_is_what_the_expert_asked_for(nominal):
    steps = [step for step in nominal.steps if not step.exchange]
    disturbed = np.array([step.disturbed for step in steps])
    assert 0 < disturbed.sum() < 0.5 * len(steps)
    np.testing.assert_array_equal(nominal.columns["expert"], ~disturbed)
    asked = np.stack([step.asked.vector() for step in steps]).astype(np.float32)
    labels = nominal.columns["action"]
    np.testing.assert_array_equal(labels[disturbed], asked[disturbed])
    altered = np.array([bool(step.altered) for step in steps])
    untouched = ~disturbed & ~altered
    np.testing.assert_allclose(labels[untouched], asked[untouched], atol=1e-6)


def test_a_burst_of_noise_moves_the_arm_and_the_expert_corrects_it(nominal):
    steps = [step for step in nominal.steps if not step.exchange]
    commands = np.stack([step.command.joints for step in steps])
    k = int(np.flatnonzero([step.disturbed for step in steps])[0])
    quiet = Shown("nominal:textbook", k + 2, noise=False)
    np.testing.assert_array_equal(quiet.steps[k - 1].command.joints, commands[k - 1])
    assert not np.allclose(quiet.steps[k + 1].command.joints, commands[k + 1], atol=1e-6)
    assert quiet.columns["expert"].all()


def test_a_led_motion_is_not_the_expert_s_and_is_flagged_until_undone(recovery):
    expert, flag = recovery.columns["expert"], recovery.columns["flag"]
    steps = [step for step in recovery.steps if not step.exchange]
    led = np.flatnonzero([step.asked is None for step in steps])
    after = led[-1] + 1
    assert len(led) > 10
    assert not expert[led].any()
    assert not flag[: led[-1] + 1].any()
    assert flag[after : after + 5].all()
    assert not flag[-1]
    assert ((recovery.columns["correction"] != "") == flag).all()
    assert (recovery.columns["instruction"] == TASKS[0].text)[flag].all()


def test_a_flag_s_correction_names_the_motion_of_the_next_second(recovery):
    frames = np.flatnonzero(recovery.columns["flag"])
    tips = recovery.columns[STATE][:, SEEN_TIPS].reshape(-1, 2, 3, 4)[..., 3]
    named = [correction_from_text(recovery.columns["correction"][k]) for k in frames]
    moving = [(k, c) for k, c in zip(frames, named, strict=True) if c.direction]
    assert moving
    for k, c in moving:
        moved = tips[k + 30, ["left", "right"].index(c.arm)] - tips[k, 0 if c.arm == "left" else 1]
        axis = {"left": 0, "right": 0, "higher": 1, "lower": 1}.get(c.direction, 2)
        assert (moved[axis] > 0) == (c.direction in ("left", "higher", "away"))


def test_a_learned_controller_hears_of_the_next_task_no_sooner_than_from_a_learned_planner(
    nominal, tmp_path
):
    untrained = tmp_path / "policy.safetensors"
    CHECKPOINTS.save(untrained, Policy(PRESETS["smoke"].policy))
    turned = PlannedDemonstration(seed=ROOMY, kind="turns", checkpoint=str(untrained))
    steps = islice(begun(turned).steps(), 450)
    turns = takewhile(lambda step: not step.exchange, steps)  # an exchange shifts the seconds
    assert past_the_second(step.instruction for step in turns) == {0.0}
    assert past_the_second(step.instruction for step in nominal.steps) > {0.0}


def past_the_second(said):
    return {round(instruction.time_s % 1.0, 3) % 1.0 for instruction in said}


def test_corrections_come_now_and_then_last_as_said_and_do_no_harm(nominal):
    class Silent:
        def reset(self):
            pass

        hears_of_success = False

        def plan(self, observation):
            return Instruction(task=TASKS[3], time_s=observation.time_s)

    world, seen = nominal.episode.world, nominal.episode.observation
    planner = PlannerInterjecting(Silent(), world, np.random.default_rng(0))
    times = np.arange(0.0, 3000.0)
    said = [planner.plan(replace(seen, time_s=t)) for t in times]
    assert all(i.task == TASKS[3] for i in said)
    given = [i.correction for i in said]
    runs = np.flatnonzero([a != b for a, b in zip([None, *given], [*given, None], strict=True)])
    lengths = np.diff(runs)
    assert set(lengths[::2]) == {1, 2}
    assert lengths[1::2].min() >= 2
    able = {c.text for c in CORRECTIONS if is_harmless(c, world)}
    assert {c.text for c in given if c} == able


def test_a_call_is_passed_on_without_a_correction(nominal):
    world, seen = nominal.episode.world, nominal.episode.observation
    calls = PlannerCalls(PolicySetup())
    planner = PlannerInterjecting(calls, world, np.random.default_rng(0))
    for time_s in np.arange(0.0, 100.0):
        now = replace(seen, time_s=time_s)
        assert planner.plan(now) == calls.plan(now)


def test_a_procedure_in_which_a_person_is_called_at_once_has_nothing_to_keep(tmp_path):
    seed = next(seed for seed in range(900, 1_000) if why_call(anatomy_from_seed(seed)))
    with pytest.raises(ValueError, match=f"seed {seed} ended before its first frame"):
        run(PlannedDemonstration(seed=seed, kind="order", noise=False), tmp_path / "part.parquet")


def test_a_patient_who_is_left_to_a_person_is_grasped_and_no_more(tmp_path):
    (planned,) = demonstrations("declined", 0, 1)
    done = demonstrate(planned, tmp_path)
    assert done.success, done.error
    shown = read_part(part_path(planned, tmp_path))
    assert set(shown.columns["task"]) == {GRAB.index, GRAB.index + 1}
    assert rollout_of(shown).declined


@pytest.mark.slow
def test_the_tubes_may_come_in_another_order_and_all_is_done(tmp_path):
    demonstration = PlannedDemonstration(seed=920, kind="order", noise=False)
    shown = run(demonstration, tmp_path / "part.parquet")
    tasks = [TASKS[index - 1] for index in dict.fromkeys(shown.columns["task"].tolist())]
    assert shown.header.success
    assert (shown.header.sense, shown.header.checkpoints) == ("tracked", {})
    assert set(tasks) == set(TASKS)
    assert tasks != list(TASKS)
    cut = [t.tube for t in tasks if t.kind == "cut"]
    assert cut == ["right", "left"]


@pytest.mark.parametrize(
    ("seed", "noise", "hears"), [(8, True, True), (9, True, False), (9, False, True)]
)
def test_in_every_other_noisy_demonstration_the_expert_hears_late(seed, noise, hears):
    planned = PlannedDemonstration(seed=seed, kind="nominal:textbook", noise=noise)
    assert begun(planned).planner.hears_of_success == hears
