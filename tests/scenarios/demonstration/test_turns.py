"""Tests of taking turns: only the policy whose turn it is acts, for as long as a turn lasts."""

from types import SimpleNamespace

import numpy as np
import pytest

from controller.action import hold
from planner.instruction import Instruction
from planner.procedure.cholecystectomy import TASKS
from scenarios.demonstration.turns import EXPERT_S, LEARNER_S, LONG_S, ControllerTakingTurns
from tissue_sim.constants import CONTROL_PERIOD_S

LATE_S = 3 * CONTROL_PERIOD_S  # a chunk of the expert is played to its end


class Counting:
    """Holds still and counts its calls."""

    def __init__(self, chunk_steps):
        self.acts, self.resets, self._chunk_steps = 0, 0, chunk_steps

    def reset(self):
        self.resets += 1

    def act(self, observation, instruction):
        self.acts += 1
        return (hold(np.zeros(2)),) * self._chunk_steps


class Played:
    """Plays the turns for a time; the task is a function of time."""

    def __init__(self, task_at, lasts_s):
        self.learner, self.expert = Counting(1), Counting(3)
        both = ControllerTakingTurns(self.learner, self.expert, np.random.default_rng(0))
        self.turns, now_s = [], 0.0
        while now_s < lasts_s:
            acts = self.learner.acts, self.expert.acts
            seen, said = SimpleNamespace(time_s=now_s), Instruction(task=task_at(now_s))
            steps = len(both.act(seen, said))
            own = int(both.expert_acts)
            assert (self.learner.acts, self.expert.acts) == (acts[0] + 1 - own, acts[1] + own)
            now_s += steps * CONTROL_PERIOD_S
            if not self.turns or self.turns[-1][0] != both.expert_acts:
                self.turns.append([both.expert_acts, 0.0])
            self.turns[-1][1] = now_s


@pytest.fixture(scope="module")
def going_well():
    return Played(lambda now_s: TASKS[int(now_s / 3.0)], 3.0 * len(TASKS) - 0.1)


def test_the_expert_begins_and_turns_last_as_long_as_they_may(going_well):
    assert going_well.turns[0][0]
    began_s = 0.0
    for expert_acts, ended_s in going_well.turns[:-1]:
        least, most = EXPERT_S if expert_acts else LEARNER_S
        assert least - LATE_S <= ended_s - began_s <= most + LATE_S
        began_s = ended_s


def test_the_policy_that_takes_over_is_reset(going_well):
    experts = sum(expert_acts for expert_acts, _ in going_well.turns)
    assert going_well.expert.resets == experts
    assert going_well.learner.resets == len(going_well.turns) - experts


def test_the_expert_ends_a_task_that_takes_long_and_all_repeated_tasks():
    played = Played(lambda now_s: TASKS[1] if now_s % 20.0 < 10.0 else TASKS[2], 60.0)
    expert_acts, ended_s = played.turns[-1]
    assert expert_acts
    assert ended_s >= 60.0
    assert 10.0 <= played.turns[-2][1] <= 10.0 + LONG_S + LATE_S
