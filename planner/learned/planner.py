"""Define the learned planner, whose only input is observations and its own past instructions."""

from __future__ import annotations

from collections import Counter, deque
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from planner.base import MOST_TRIES, failed_too_often
from planner.correction import CORRECTIONS
from planner.instruction import TASKS, Assessment, Instruction, Task
from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import CHECKPOINTS, Moments, PlannerNetwork, Prediction
from planner.learning.networks import one_thread
from planner.policy_setup import PolicySetup
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.rules.anatomy_gate import room_in_words
from planner.rules.call_gates import STANDSTILL, UNSEEN, SightGate, StandstillGate
from planner.rules.interlocks import forbidden
from planner.rules.rule_use import ANY, RuleCounts, RuleUse
from planner.rules.task_gate import TaskClock
from planner.scene.predicates import is_low
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.rest_frame import RestFrame

FLAG_ABOVE = 0.5  # probability that a correction is needed; assumed
MOST_CORRECTIONS = 3  # in the network's history; assumed
SURE = 0.7  # probability from which another task is given at once; assumed
# Probability that a person must be called: before the first clip is due a call can wait until the
# network is certain.
CALL_EARLY, CALL_DUE = 0.95, 0.5  # assumed
UNSURE = "The chance is {:.0%} that this is no case for the robot: a person must look."


RULES = (
    "interlocks",
    "certainty of a new task",
    "limit of corrections",
    "call: standstill",
    "call: sight",
)
"""Rules that overrule the network, in the order in which they are applied."""


class _Moment(NamedTuple):
    """The time of a request to the planner, the observation, and the instruction in force."""

    time_s: float
    vector: NDArray[np.float32]
    task: int
    correction: int
    since_s: float
    tries: int


class PlannerLearned:
    """Gives the instruction that the network predicts from the last moments.

    The planner changes the task when the network is sure of another task, or still prefers that
    task a second later. A late change costs a second, but an early change leaves a task undone.
    Hand-written rules overrule the network (`RULES`):

    - Interlocks mask tasks that nobody may order (`planner.rules.interlocks`).
    - Corrections that have not helped for some seconds make room for the task itself.
    - The planner calls for a person where the tubes are observed badly (`SightGate`).
    - The planner calls for a person where the arms stand still (`StandstillGate`).

    The network itself calls for a person where the tubes have no room, or a clip or a cut has
    failed too often. The number of a tube's clips follows from its length, as observed before any
    tool pulled at it. The planner raises an alarm where a task's chance of failure is high twice in
    a row.

    With `alone`, only the calls for bad sight and a standstill are left of the rules.
    """

    def __init__(self, network: PlannerNetwork, *, alone: bool = False) -> None:
        self._network, self._alone = network, alone
        self.reset()

    def reset(self) -> None:
        """Forget the episode so far."""
        self._moments: deque[_Moment] = deque(maxlen=self._network.config.history)
        self._task, self._correction = N_TASKS, N_CORRECTIONS
        self._preferred, self._has_cut = N_TASKS, False
        self._tries, self._clock = Counter[int](), TaskClock()
        self._uneasy = False
        self._frame = RestFrame()
        self._sight, self._standstill = SightGate(), StandstillGate()
        self._rules = RuleCounts("planner", RULES)

    def rule_uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule that overrules the network, in the episode so far."""
        return self._rules.uses()

    def plan(self, observation: Observation) -> Instruction:
        """Return the task that should be given now, with a correction if one is needed."""
        self._remember(observation)
        self._standstill.update(observation)
        self._sight.update(observation)
        with torch.inference_mode(), one_thread():
            opinion = self._network(self._stacked())
            fails = self._network.failure_chance(opinion).item()
        chances = self._chances(opinion.task[0], observation)
        self._take_up(chances)
        task = TASKS[self._task]
        self._rules.note(ANY, changed=self._task != int(opinion.task[0].argmax()))
        if (why := self._why_call(task, opinion, observation)) is not None:
            return Instruction(
                task=task, hold=True, call=True, remark=why, time_s=observation.time_s
            )
        uneasy, self._uneasy = self._uneasy, fails > self._network.alarm.item()
        given = sum(moment.correction != N_CORRECTIONS for moment in self._moments)
        flagged = opinion.flag.sigmoid().item() > FLAG_ABOVE
        opens_first = task.grasps and is_low(observation)
        limited = (given >= MOST_CORRECTIONS or opens_first) and not self._alone
        wanted = flagged and not limited
        self._rules.note("limit of corrections", changed=flagged and not wanted)
        self._correction = int(opinion.correction.argmax()) if wanted else N_CORRECTIONS
        return Instruction(
            task=task,
            correction=CORRECTIONS[self._correction] if wanted else None,
            confidence=chances[self._task].item(),
            time_s=observation.time_s,
            assessment=Assessment(
                progress=opinion.progress.item(),
                failure_chance=fails,
                alarm=uneasy and self._uneasy,
            ),
        )

    def _why_call(self, task: Task, opinion: Prediction, observation: Observation) -> str | None:
        """Return the reason why a person must be called now; None if there is no reason."""
        if self._calls("call: standstill", self._standstill.lasts):
            return STANDSTILL
        if self._calls("call: sight", self._sight.is_lost):
            return UNSEEN
        chance = opinion.calls.sigmoid().item()
        if chance <= (CALL_DUE if task.is_deed else CALL_EARLY):
            return None
        if self._tries[self._task] > MOST_TRIES:
            return failed_too_often(task)
        return room_in_words(observation) or UNSURE.format(chance)

    def _calls(self, rule: str, calls: bool) -> bool:
        self._rules.note(rule, changed=calls)
        return calls

    def _remember(self, observation: Observation) -> None:
        """Add a moment to the memory."""
        self._clock.update(observation)
        seen, since_s = self._frame.follow(observation.vector()), self._clock.since_s
        self._moments.append(
            _Moment(
                time_s=observation.time_s,
                vector=seen,
                task=self._task,
                correction=self._correction,
                since_s=since_s,
                tries=self._tries[self._task],
            )
        )

    def _chances(self, logits: torch.Tensor, observation: Observation) -> torch.Tensor:
        """Return the probability of each task that may be ordered."""
        if self._alone:
            return logits.softmax(dim=-1)
        masked = torch.tensor(forbidden(observation, has_cut=self._has_cut), dtype=torch.long)
        asked, logits = int(logits.argmax()), logits.index_fill(0, masked, -torch.inf)
        self._rules.note("interlocks", changed=int(logits.argmax()) != asked)
        return logits.softmax(dim=-1)

    def _take_up(self, chances: torch.Tensor) -> None:
        task = int(chances.argmax())
        certain = self._alone or chances[task] >= SURE
        sure = certain or task == self._preferred or self._task == N_TASKS
        self._preferred = task
        self._rules.note("certainty of a new task", changed=not sure and task != self._task)
        if sure and task != self._task:
            self._task, self._uneasy = task, False
            self._clock.begin()
            self._tries[task] += 1
            self._has_cut |= _comes_from_cut(TASKS[task])

    def _stacked(self) -> Moments:
        """Return the history; copies of the first, marked unknown, fill the start."""
        missing = self._network.config.history - len(self._moments)
        rows = [self._moments[0]] * missing + list(self._moments)
        return Moments(
            frames=torch.from_numpy(np.stack([row.vector for row in rows]))[None],
            known=(torch.arange(len(rows)) >= missing)[None],
            task=torch.tensor([[row.task for row in rows]]),
            correction=torch.tensor([[row.correction for row in rows]]),
            since_s=torch.tensor([[row.since_s for row in rows]]),
            tries=torch.tensor([[row.tries for row in rows]]),
        )


def _comes_from_cut(task: Task) -> bool:
    """Return whether a task is the retraction from a cut."""
    return task.goes_back and CHOLECYSTECTOMY.before(task).severs


def make(setup: PolicySetup, *, alone: bool = False) -> PlannerLearned:
    """Return the planner of the checkpoint in its setup.

    Raises:
        CheckpointError: There is no checkpoint, or the checkpoint does not fit.
    """
    return PlannerLearned(CHECKPOINTS.load(setup.checkpoint), alone=alone)


def make_alone(setup: PolicySetup) -> PlannerLearned:
    """Return the same with a network that decides alone on tasks."""
    return make(setup, alone=True)
