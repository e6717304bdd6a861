"""By turns: who acts is who is asked, for as long as a turn lasts."""

import numpy as np
import pytest

from controller.action import CONTROL_STEP_S, hold
from scenarios.demonstration.turns import EXPERT_S, LEARNER_S, ControllerTakingTurns


class Counting:
    """Holds still and counts what it is asked."""

    def __init__(self, chunk_steps):
        self.acts, self.resets, self._chunk_steps = 0, 0, chunk_steps

    def reset(self):
        self.resets += 1

    def act(self, observation, instruction):
        self.acts += 1
        return (hold(np.zeros(2)),) * self._chunk_steps


@pytest.fixture
def turns():
    """Who had each turn, its length in s, and both controllers."""
    learner, expert = Counting(1), Counting(3)
    both = ControllerTakingTurns(learner, expert, np.random.default_rng(0))
    lengths = []
    for _ in range(3000):
        before = learner.acts, expert.acts
        steps = len(both.act(None, None))
        assert (learner.acts, expert.acts) == (
            before[0] + (not both.expert_acts),
            before[1] + both.expert_acts,
        )
        if not lengths or lengths[-1][0] != both.expert_acts:
            lengths.append([both.expert_acts, 0.0])
        lengths[-1][1] += steps * CONTROL_STEP_S
    return lengths, learner, expert


def test_the_expert_begins_and_turns_last_as_long_as_they_may(turns):
    lengths, *_ = turns
    assert lengths[0][0]
    for expert_acts, lasted_s in lengths[:-1]:
        least, most = EXPERT_S if expert_acts else LEARNER_S
        assert least - CONTROL_STEP_S <= lasted_s <= most + 3 * CONTROL_STEP_S


def test_who_takes_over_begins_anew(turns):
    lengths, learner, expert = turns
    assert expert.resets == sum(acts for acts, _ in lengths)
    assert learner.resets == sum(not acts for acts, _ in lengths)
