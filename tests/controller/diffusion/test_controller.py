"""Tests of the controller: chunks take over where promised, and new words act at once."""

from collections import deque
from dataclasses import replace

import numpy as np
import pytest
import torch

from controller.action import hold
from controller.diffusion.chunk_frame import JAWS, past_of
from controller.diffusion.config import PolicyConfig
from controller.diffusion.controller import FADE, ControllerDiffusion
from controller.diffusion.graph import Sampler
from controller.diffusion.policy import Policy
from controller.diffusion.rules.chunk_rules import RULES
from controller.diffusion.rules.holding import HELD_RAD
from planner.instruction import TASKS, Instruction
from tests.planner.observations import clipped
from tissue_sim.sensing.observation import fields

CONFIG = PolicyConfig(condition_width=16, condition_blocks=1, denoiser_width=16, denoiser_blocks=1)
GRAB, CLIP, NEXT = (Instruction(task=TASKS[k]) for k in (0, 1, 3))
SEEN = replace(clipped(), joints=np.full((2, 7), 0.1))


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    torch.manual_seed(0)
    policy = Policy(CONFIG)
    policy.chunk_mean += torch.arange(16.0)[:, None] * 1e-3 + 0.1
    policy.chunk_deviation *= 1e-3
    return Sampler(policy.eval().requires_grad_(False))


def controller(sampler: Sampler, **options) -> ControllerDiffusion:
    return ControllerDiffusion(CONFIG, sampler, **options)


def played(controller: ControllerDiffusion, n: int, said: Instruction = CLIP) -> np.ndarray:
    seen = [replace(SEEN, forces_n=np.full((2, 3), 0.1 * k)) for k in range(n)]
    return np.stack([controller.act(s, said)[0].vector() for s in seen])


def resting(jaw_rad: float) -> np.ndarray:
    """Return a chunk whose tools stand still with their jaws at an angle."""
    return np.tile(hold(np.full(2, jaw_rad)).vector(), (CONFIG.horizon, 1))


@pytest.mark.parametrize("delay", [0, 2, 4])
def test_a_chunk_takes_over_after_the_promised_motions_for_any_delay(sampler, delay):
    subject, places = controller(sampler, delay=delay), []
    for _ in range(2 * CONFIG.play + 1):
        _ = subject.act(SEEN, GRAB)
        places.append(subject.place)
    inside = ["inside"] * (CONFIG.play - 1)
    assert places == ["fresh", *inside, "joint", *inside, "joint"]


def test_committed_motions_are_played_unchanged(sampler):
    prompt, late = (played(controller(sampler, delay=d), CONFIG.play + 1) for d in (0, 4))
    np.testing.assert_allclose(late[: CONFIG.play], prompt[: CONFIG.play], atol=1e-9)
    assert not np.allclose(late[CONFIG.play], prompt[CONFIG.play])


@pytest.mark.parametrize("delay", [0, 2, 4])
def test_each_chunk_is_given_the_motions_that_lead_up_to_it(sampler, delay):
    given = []
    subject = controller(lambda inputs: given.append(inputs) or sampler(inputs), delay=delay)
    rows = np.concatenate([played(subject, 20), played(subject, 1, NEXT)])
    joints = [0, 6, 12, 18, 20]
    assert len(given) == len(joints)
    for at, inputs in zip(joints, given, strict=True):
        n = min(at, CONFIG.past)
        assert inputs["n_past"] == n
        assert inputs["delay"] == (delay if 0 < at < 20 else 0)
        if at > n:
            led = past_of(rows[at - n : at], rows[at - n - 1, JAWS])
            np.testing.assert_allclose(inputs["past"], led, atol=1e-6)
            np.testing.assert_allclose(inputs["jaw_rad"], rows[at - 1, JAWS], atol=1e-6)


def test_a_new_chunk_fades_in_step_by_step():
    """Play chunks with jaws at 1 rad, then at 2: the jaw angle tells which chunk is played."""
    chunks = iter([resting(1.0), resting(2.0)])
    rows = played(controller(lambda inputs: next(chunks)), CONFIG.play + FADE + 2)
    jaws = rows[:, JAWS][:, 0]
    np.testing.assert_allclose(jaws[: CONFIG.play], 1.0)
    shares = np.arange(1, FADE + 1) / (FADE + 1)
    np.testing.assert_allclose(jaws[CONFIG.play : CONFIG.play + FADE], 1.0 + shares)
    np.testing.assert_allclose(jaws[CONFIG.play + FADE :], 2.0)


def test_alone_it_plays_what_its_policy_says_and_with_rules_what_hardly_moves_rests():
    rests = SEEN.joints[:, 6]
    chunk = resting(rests[0] + 0.5 * HELD_RAD)
    alone, ruled = (
        played(controller(lambda inputs: chunk, without_rules=rules), CONFIG.play)[:, JAWS]
        for rules in (RULES, ())
    )
    np.testing.assert_allclose(alone, rests[0] + 0.5 * HELD_RAD)
    np.testing.assert_allclose(ruled, np.tile(rests, (CONFIG.play, 1)))


def test_new_words_drop_the_running_chunk_at_once(sampler):
    subject = controller(sampler, delay=2)
    _ = played(subject, 3)
    motion = played(subject, 1, NEXT)
    assert subject.place == "fresh"
    assert not np.allclose(motion, played(controller(sampler, delay=2), 4)[3])


def test_a_wordless_controller_ignores_words(sampler):
    subject = ControllerDiffusion(replace(CONFIG, wordless=True), sampler)
    motions = np.concatenate([played(subject, 3, CLIP), played(subject, 1, NEXT)])
    assert subject.place == "inside"
    silent = ControllerDiffusion(replace(CONFIG, wordless=True), sampler)
    parts = [played(silent, 3, NEXT), played(silent, 1, CLIP)]
    np.testing.assert_array_equal(motions, np.concatenate(parts))


def test_the_same_seed_gives_the_same_motion_and_another_seed_another(sampler):
    first, again, other = (played(controller(sampler, seed=seed), 20) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert not np.allclose(first, other)


def test_with_a_late_robot_it_sees_the_tools_where_a_prompt_robot_has_them():
    """Check this after the controller has seen the robot move; the chunks are made up."""
    chunks = 2e-3 * np.sin(np.arange(8 * CONFIG.horizon * 20.0) ** 2).reshape(8, -1, 20)

    def tips_given(late: int) -> list[np.ndarray]:
        given, left = [], iter(np.cumsum(chunks, axis=1))
        subject = controller(lambda inputs: given.append(inputs["history"]) or next(left))
        tips, on_their_way = SEEN.tips_endoscope.copy(), deque(maxlen=late + 1)
        for _ in range(8 * CONFIG.play - 1):
            seen = replace(SEEN, tips_endoscope=tips.copy())
            on_their_way.append(subject.act(seen, GRAB)[0])
            if len(on_their_way) > late:
                tips[:, :3, 3] += on_their_way[0].move_endoscope_m
        return [fields(history)["tips_endoscope"][..., 3] for history in given]

    prompt, late = tips_given(0), tips_given(7)
    assert not np.allclose(late[1], prompt[1], atol=1e-5)  # it has not seen the robot move
    np.testing.assert_allclose(late[-3:], prompt[-3:], atol=1e-6)


def test_a_reset_forgets_all_observations(sampler):
    subject = controller(sampler)
    _ = played(subject, 9)
    subject.reset()
    again = played(subject, 1)
    assert subject.place == "fresh"
    assert not np.allclose(again, played(controller(sampler), 10)[9])


def test_a_delay_longer_than_trained_for_is_refused(sampler):
    with pytest.raises(ValueError, match="delay must be 0 to 4 control steps, got 5"):
        controller(sampler, delay=5)


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"history": (3, 0)}, "history must begin with the present frame"),
        ({"play": 17}, "play must be 1 to 16 motions, got 17"),
        ({"past": 3}, "max_delay must be 0 to 3, .* got 4"),
    ],
)
def test_shapes_that_do_not_fit_together_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        PolicyConfig(**wrong)
