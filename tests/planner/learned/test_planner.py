"""Tests of the learned planner: it uses the inputs of its training and nothing else."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from planner.base import MOST_TRIES, PATIENCE_S
from planner.correction import CORRECTIONS
from planner.learned.config import PlannerConfig
from planner.learned.network import Moments, PlannerNetwork
from planner.learned.planner import MOST_CORRECTIONS, STALE_S, SURE, PlannerLearned
from planner.learned.rollout import NOT_SAID, Rollouts
from planner.task import TASKS, Task
from tests.planner.learned.rolled_out import rollout
from tests.planner.seen import clipped
from tissue_sim.periods import CONTROL_HZ
from tissue_sim.sensing.observation import POINTS, VECTOR_SIZE, fields, observation_of

CONFIG = PlannerConfig(history=4, width=32, layers=1)
GRAB, GOING_BACK, CUT, BACK_FROM_CUT, CLIP = (TASKS[k] for k in (0, 6, 7, 8, 9))
ROWS = range(0, 10 * CONTROL_HZ, CONTROL_HZ)


@pytest.fixture(scope="module")
def network() -> PlannerNetwork:
    torch.manual_seed(0)
    network = PlannerNetwork(CONFIG)
    network.normalise_by(torch.from_numpy(rollout().states))
    return network.eval().requires_grad_(False)


def said_to(planner: PlannerLearned, states: np.ndarray, start_s: float = 0.0) -> list:
    return [planner.plan(observation_of(states[row], start_s + row / CONTROL_HZ)) for row in ROWS]


@pytest.mark.parametrize("sharpness", [1.0, 1e4])
def test_it_follows_its_network_once_sure_or_when_the_network_repeats(
    network, sharpness, monkeypatch
):
    monkeypatch.setattr("planner.learned.planner.MOST_TRIES", len(ROWS))
    network = sharpened(network, sharpness)
    states = rollout(4).states[: ROWS[-1] + 1]
    said = said_to(PlannerLearned(network), states)
    n = np.arange(len(states)) // CONTROL_HZ
    numbers = {None: NOT_SAID} | {c: k for k, c in enumerate(CORRECTIONS)}
    corrected = [numbers[s.correction] for s in said]
    as_run = replace(
        rollout(4),
        states=states,
        said=np.array([s.task.index - 1 for s in said])[n],
        corrected=np.array(corrected)[n],
        task=n,
        correction=np.full(len(n), NOT_SAID),
    )
    data = Rollouts([as_run], CONFIG.history)
    at = torch.tensor(ROWS)
    prediction = network(data.moments(at, torch.full_like(at, 30), torch.ones_like(at)))
    logits, cuts = prediction.task.clone(), [s.task.kind == "go_back_from_cut" for s in said]
    logits[1 + cuts.index(True) if any(cuts) else len(said) :, TASKS.index(GRAB)] = -torch.inf
    chances, preferred = logits.softmax(dim=-1), logits.argmax(dim=-1).tolist()
    held_back = 0
    for k in range(1, len(said)):
        sure = chances[k].max() >= SURE or preferred[k] == preferred[k - 1]
        assert said[k].task == (TASKS[preferred[k]] if sure else said[k - 1].task)
        assert said[k].confidence == pytest.approx(
            chances[k, said[k].task.index - 1].item(), abs=1e-5
        )
        held_back += said[k].task != TASKS[preferred[k]]
    assert said[0].task == TASKS[preferred[0]]
    assert bool(held_back) == (sharpness == 1.0)
    failure = network.failure_chance(prediction)
    np.testing.assert_allclose([s.assessment.failure_chance for s in said], failure, atol=1e-5)


def sharpened(network: PlannerNetwork, by: float) -> PlannerNetwork:
    """Return a network that prefers the same tasks with more certainty."""
    other = PlannerNetwork(CONFIG).eval()
    other.load_state_dict(network.state_dict())
    for parameter in other.leave[1].parameters():
        parameter.data[: len(TASKS)] *= by
    return other.requires_grad_(False)


@pytest.mark.parametrize("chance", [0.6, 0.9, 0.99])
def test_going_back_without_success_is_left_later_if_the_network_is_surer(network, chance):
    due_s = PATIENCE_S + STALE_S * (max(math.log2(chance / (1.0 - chance)), 1.0) - 1.0)
    said = said_for(due_s + 8.0, torn(network, GOING_BACK, CUT, chance))
    left_s = said.index(CUT)
    assert due_s < left_s <= due_s + 3.0  # the second time in a row it switches
    assert set(said[:left_s]) == {GOING_BACK}
    assert said[-1] == GOING_BACK


@pytest.mark.parametrize(("chance", "stays"), [(0.6, False), (0.9, True)])
def test_a_cut_without_success_is_left_only_for_a_task_that_is_nearly_as_likely(
    network, chance, stays
):
    said = said_for(60.0, torn(network, CUT, GOING_BACK, chance))
    assert (set(said) == {CUT}) == stays
    assert set(said[: int(PATIENCE_S)]) == {CUT}


@pytest.mark.parametrize(("before", "after"), [(CUT, GRAB), (BACK_FROM_CUT, CLIP)])
def test_after_a_cut_it_never_asks_to_grasp_again(network, before, after):
    planner, state = PlannerLearned(torn(network, before, CLIP, 0.99)), rollout().states[0]
    assert planner.plan(observation_of(state, 0.0)).task == before
    planner._network = torn(network, GRAB, CLIP, 0.9)
    assert {planner.plan(observation_of(state, float(s))).task for s in range(2, 8)} == {after}
    planner.reset()
    assert planner.plan(observation_of(state, 0.0)).task == GRAB


def test_a_clip_that_has_been_tried_three_times_is_left_to_a_person(network):
    planner, times = PlannerLearned(network), 0
    at_home = observation_of(rollout().states[0], 0.0)
    for k in range(2 * MOST_TRIES + 1):
        wanted = (CLIP, GOING_BACK)[k % 2]
        planner._network = torn(network, wanted, GRAB, 0.99)
        said = planner.plan(replace(at_home, time_s=float(k)))
        times += wanted is CLIP
        assert said.call == (times > MOST_TRIES), k
    assert said.hold
    assert "3 times" in said.remark


def said_for(time_s: float, network: PlannerNetwork) -> list[Task]:
    """Return the tasks given once a second; the arms go to and fro, so that nobody is called."""
    planner, states = PlannerLearned(network), rollout().states[[0, 1]]
    return [planner.plan(observation_of(states[s % 2], float(s))).task for s in range(int(time_s))]


def torn(network: PlannerNetwork, one: Task, other: Task, chance: float) -> PlannerNetwork:
    """Return a network that gives `one` this chance and `other` the rest, for any observation."""
    made = PlannerNetwork(CONFIG).eval()
    made.load_state_dict(network.state_dict())
    made.leave[1].weight.data[: len(TASKS)] = 0.0
    made.leave[1].bias.data[: len(TASKS)] = -50.0
    for task, share in ((one, chance), (other, 1.0 - chance)):
        made.leave[1].bias.data[TASKS.index(task)] = math.log(share)
    return made.requires_grad_(False)


def test_it_forgets_the_episode_before_and_absolute_time_has_no_effect(network):
    planner = PlannerLearned(network)
    states = rollout(2).states
    first = said_to(planner, states)
    planner.reset()
    again = said_to(planner, states, start_s=100.0)
    assert [replace(s, time_s=0.0) for s in again] == [replace(s, time_s=0.0) for s in first]


def carried(states: np.ndarray) -> np.ndarray:
    """Return the same observations for a body that moves."""
    moved = states.copy()
    ways = 0.02 * np.random.default_rng(3).standard_normal((len(states), 1, 3)).astype(np.float32)
    ways[0] = 0.0
    parts = fields(moved)  # views
    for name in POINTS:
        parts[name] += ways
    parts["tips_endoscope"][..., 3] += ways
    return moved


def test_a_moving_body_gives_the_same_training_data_as_one_at_rest():
    still, moving = rollout(3), replace(rollout(3), states=carried(rollout(3).states))
    learnt = [Rollouts([r], CONFIG.history).steps.states for r in (still, moving)]
    np.testing.assert_allclose(learnt[1], learnt[0], atol=1e-6)


def test_a_moving_body_gives_the_same_instructions_as_one_at_rest(network):
    states = rollout(3).states
    still, moving = (said_to(PlannerLearned(network), s) for s in (states, carried(states)))
    assert [s.text for s in moving] == [s.text for s in still]
    for one, other in zip(moving, still, strict=True):
        assert one.confidence == pytest.approx(other.confidence, abs=1e-4)


def test_unknown_moments_have_no_effect(network):
    torch.manual_seed(0)
    known = torch.tensor([[False, False, True, True]])
    moments = Moments(
        frames=torch.randn(1, 4, VECTOR_SIZE),
        known=known,
        task=torch.tensor([[0, 1, 2, 3]]),
        correction=torch.tensor([[0, 1, 2, 3]]),
        since_s=torch.rand(1, 4),
    )
    other = moments._replace(
        frames=torch.where(known[..., None], moments.frames, torch.zeros(())),
        task=torch.where(known, moments.task, 9),
        correction=torch.where(known, moments.correction, 9),
        since_s=torch.where(known, moments.since_s, torch.zeros(())),
    )
    for a, b in zip(network(moments), network(other), strict=True):
        torch.testing.assert_close(a, b)
    seen_otherwise = moments._replace(frames=moments.frames + 0.1)
    assert not torch.allclose(network(moments).task, network(seen_otherwise).task, atol=1e-3)


def test_it_corrects_only_under_its_flag(network):
    torch.manual_seed(1)
    for flag, n_corrected in ((-50.0, 0), (50.0, MOST_CORRECTIONS)):
        biased = PlannerNetwork(CONFIG).eval()
        biased.load_state_dict(network.state_dict())
        biased.leave[1].bias.data[-3] = flag
        said = said_to(PlannerLearned(biased.requires_grad_(False)), rollout(3).states)
        corrected = [s.correction is not None for s in said]
        windows = [corrected[k : k + CONFIG.history] for k in range(len(said) - CONFIG.history)]
        assert max(sum(window) for window in windows) == n_corrected


@pytest.mark.parametrize(
    ("length_m", "clips", "due"),
    [
        (0.028, 0, ["first", "second", "third"]),
        (0.028, 1, ["first", "second", "second"]),
        (0.028, 2, ["first", "second", "third"]),
        (0.028, 3, ["back", "back", "back"]),
        (0.017, 0, ["first", "third", "third"]),
        (0.017, 1, ["first", "third", "third"]),
        (0.017, 2, ["back", "back", "back"]),
    ],
)
@pytest.mark.parametrize("tube", ["left", "right"])
def test_a_clip_that_has_no_place_gives_way_to_what_is_due(network, tube, length_m, clips, due):
    """The tube that is looked at is the duct."""
    seen = replace(clipped(**{tube: clips}, duct=tube), rest_length_m=np.full(2, length_m))
    planner = PlannerLearned(network)
    named = {name: f"clipping {name} clip {tube} tube" for name in ("first", "second", "third")}
    named["back"] = f"going back third clip {tube} tube"
    for name, expected in zip(("first", "second", "third"), due, strict=True):
        k = next(k for k, task in enumerate(TASKS) if task.text == named[name])
        assert TASKS[planner._due(k, seen)].text == named[expected]


@pytest.mark.parametrize("tube", ["left", "right"])
def test_a_cut_that_is_made_is_not_asked_for_again(network, tube):
    planner, severed = PlannerLearned(network), np.array([tube == "left", tube == "right"])
    cut = next(k for k, task in enumerate(TASKS) if task.kind == "cut" and task.tube == tube)
    made = replace(clipped(left=3, right=3), severed=severed)
    assert TASKS[planner._due(cut, made)].text == f"go back from the cut {tube} tube"
    assert planner._due(cut, replace(made, severed=~severed)) == cut
