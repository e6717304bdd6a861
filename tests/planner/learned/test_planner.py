"""Tests of the learned planner: it uses the inputs of its training and nothing else."""

import math
from dataclasses import replace

import numpy as np
import pytest
import torch

from planner.correction import CORRECTIONS
from planner.learned.network import Moments, PlannerConfig, PlannerNetwork
from planner.learned.planner import CALL_DUE, CALL_EARLY, MOST_CORRECTIONS, SURE, PlannerLearned
from planner.learned.rollout import NOT_SAID, Rollouts
from planner.procedure.cholecystectomy import TASKS
from planner.procedure.task import Task
from planner.rules.interlocks import forbidden
from tests.planner.learned.rolled_out import rollout, with_tasks
from tests.planner.observations import at_work, clipped
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.sensing.observation import (
    POINTS,
    VECTOR_SIZE,
    fields,
    observation_of,
)

CONFIG = PlannerConfig(history=4, width=32, layers=1)
GRAB, FIRST, CUT, BACK_FROM_CUT, CLIP = (TASKS[k] for k in (0, 1, 7, 8, 9))
LONG_S = 8
REST = -4  # the network's last outputs: flag, progress, failure and call
ROWS = range(0, 10 * CONTROL_HZ, CONTROL_HZ)
JOINTS = np.zeros((2, 7)), np.full((2, 7), 0.5)  # to and fro, so that nobody is called


@pytest.fixture(scope="module")
def network() -> PlannerNetwork:
    torch.manual_seed(0)
    network = PlannerNetwork(CONFIG)
    network.normalise_by(torch.from_numpy(rollout().states))
    network.leave[1].bias.data[-1] = -50.0  # it calls nobody
    return network.eval().requires_grad_(False)


def said_to(planner: PlannerLearned, states: np.ndarray, start_s: float = 0.0) -> list:
    return [planner.plan(observation_of(states[row], start_s + row / CONTROL_HZ)) for row in ROWS]


@pytest.mark.parametrize("sharpness", [1.0, 1e4])
def test_it_follows_its_network_once_sure_or_when_the_network_repeats(network, sharpness):
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
    chances = torch.stack([allowed(prediction.task[k], said[:k], states) for k in range(len(said))])
    preferred = chances.argmax(dim=-1).tolist()
    for k in range(1, len(said)):
        sure = chances[k].max() >= SURE or preferred[k] == preferred[k - 1]
        assert said[k].task == (TASKS[preferred[k]] if sure else said[k - 1].task)
        assert said[k].confidence == pytest.approx(
            chances[k, said[k].task.index - 1].item(), abs=1e-5
        )
    assert said[0].task == TASKS[preferred[0]]
    failure = network.failure_chance(prediction)
    np.testing.assert_allclose([s.assessment.failure_chance for s in said], failure, atol=1e-5)


def sharpened(network: PlannerNetwork, by: float) -> PlannerNetwork:
    """Return a network that prefers the same tasks with more certainty."""
    other = PlannerNetwork(CONFIG).eval()
    other.load_state_dict(network.state_dict())
    for parameter in other.leave[1].parameters():
        parameter.data[: len(TASKS)] *= by
    return other.requires_grad_(False)


@pytest.mark.parametrize(("chance", "waits"), [(0.6, True), (0.9, False)])
def test_it_waits_a_second_where_it_is_not_sure(network, chance, waits):
    planner = PlannerLearned(torn(network, GRAB, CLIP, 0.99))
    assert {s.task for s in said_for(planner, LONG_S)} == {GRAB}
    planner._network = torn(network, CLIP, GRAB, chance)
    said = said_for(planner, 2, LONG_S)
    assert [s.task for s in said] == [GRAB if waits else CLIP, CLIP]


def test_an_alarm_needs_two_looks_in_a_row_in_one_task(network):
    asks, leaves = torn(network, GRAB, CLIP, 0.99), torn(network, CLIP, GRAB, 0.99)
    asks.alarm.fill_(-1.0)  # any chance of failure is too high
    leaves.alarm.fill_(-1.0)
    planner = PlannerLearned(asks)
    said = said_for(planner, LONG_S)
    planner._network = leaves
    said += said_for(planner, 2, LONG_S)
    assert [s.task for s in said] == LONG_S * [GRAB] + 2 * [CLIP]
    assert [s.assessment.alarm for s in said] == [False] + (LONG_S - 1) * [True] + [False, True]
    asks.alarm.fill_(1.0)
    assert not any(s.assessment.alarm for s in said_for(PlannerLearned(asks), 2))


def said_for(planner: PlannerLearned, n: int, start_s: int = 0) -> list:
    """Return what it says in `n` seconds in which nothing changes."""
    return [planner.plan(clipped(time_s=float(start_s + k))) for k in range(n)]


def allowed(logits: torch.Tensor, said: list, states: np.ndarray) -> torch.Tensor:
    """Return the chances of the tasks that may be ordered after `said`, one each second."""
    k = len(said)
    has_cut = any(s.task.goes_back and TASKS[s.task.index - 2].severs for s in said)
    masked = forbidden(observation_of(states[k * CONTROL_HZ], float(k)), has_cut=has_cut)
    return logits.index_fill(0, torch.tensor(masked, dtype=torch.long), -torch.inf).softmax(dim=-1)


@pytest.mark.parametrize("asked", [GRAB, FIRST, BACK_FROM_CUT, CUT])
def test_alone_it_gives_what_its_network_asks_for(network, asked):
    says, ready = torn(network, asked, CLIP, 0.9), at_work(left=2, back=True)
    assert PlannerLearned(says, alone=True).plan(ready).task == asked
    assert PlannerLearned(says).plan(ready).task == (CLIP if asked == CUT else asked)


def test_it_orders_what_its_network_asks_for_whatever_is_seen_to_be_due(network):
    for asked in (GRAB, CLIP, BACK_FROM_CUT):
        says = torn(network, asked, CUT, 0.9)
        assert PlannerLearned(says).plan(at_work(left=3, back=True)).task == asked


def test_after_a_cut_it_never_asks_to_grasp_again(network):
    planner, ready = PlannerLearned(torn(network, BACK_FROM_CUT, CLIP, 0.99)), at_work(left=3)
    assert planner.plan(ready).task == BACK_FROM_CUT
    planner._network = torn(network, GRAB, CLIP, 0.9)
    assert {planner.plan(replace(ready, time_s=float(s))).task for s in range(1, 6)} == {CLIP}
    planner.reset()
    assert planner.plan(ready).task == GRAB


def test_after_a_persons_cut_it_does_not_ask_to_grasp_either(network):
    planner = PlannerLearned(torn(network, GRAB, FIRST, 0.9))
    made = replace(at_work(right=3, back=True), severed=np.array([False, True, False]))
    assert planner.plan(made).task == FIRST


@pytest.mark.parametrize("asked", [GRAB, CLIP])
def test_its_network_calls_a_person_before_the_first_clip_only_when_certain(network, asked):
    least = CALL_DUE if asked.is_deed else CALL_EARLY
    for chance, calls in ((least - 0.02, False), (least + 0.02, True)):
        says = torn(network, asked, CUT, 0.99)
        says.leave[1].weight.data[-1] = 0.0
        says.leave[1].bias.data[-1] = math.log(chance / (1.0 - chance))
        said = PlannerLearned(says).plan(at_work())
        assert (said.call, said.hold) == (calls, calls)
        assert not calls or f"{chance:.0%}" in said.remark


def test_its_network_hears_how_often_a_task_was_given(network):
    planner, heard = PlannerLearned(torn(network, FIRST, GRAB, 0.99)), []
    for second in range(6):
        planner._network = torn(network, (FIRST, TASKS[2])[second % 2], GRAB, 0.99)
        planner.plan(replace(at_work(), time_s=float(second), joints=JOINTS[second % 2]))
        heard.append((planner._moments[-1].task, planner._moments[-1].tries))
    assert heard == [(len(TASKS), 0), (1, 1), (2, 1), (1, 2), (2, 2), (1, 3)]
    data = Rollouts([with_tasks([1, 2, 1, 2, 1])], CONFIG.history)
    assert data.steps.tries[:: 4 * CONTROL_HZ].tolist() == [1, 1, 2, 2, 3]


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
        parts[name] += ways if name != "tubes_m" else ways[:, None]
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
        tries=torch.tensor([[0, 1, 2, 3]]),
    )
    other = moments._replace(
        frames=torch.where(known[..., None], moments.frames, torch.zeros(())),
        task=torch.where(known, moments.task, 9),
        correction=torch.where(known, moments.correction, 9),
        since_s=torch.where(known, moments.since_s, torch.zeros(())),
        tries=torch.where(known, moments.tries, 4),
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
        biased.leave[1].bias.data[REST] = flag
        said = said_to(PlannerLearned(biased.requires_grad_(False)), rollout(3).states)
        corrected = [s.correction is not None for s in said]
        windows = [corrected[k : k + CONFIG.history] for k in range(len(said) - CONFIG.history)]
        assert max(sum(window) for window in windows) == n_corrected
