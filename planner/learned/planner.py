"""The learned planner: its only input is observations and its own past instructions."""

from __future__ import annotations

from collections import Counter, deque
from pathlib import Path
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from planner.assessment import Assessment
from planner.base import MOST_TRIES, failed_too_often
from planner.correction import CORRECTIONS
from planner.instruction import TASKS, Instruction, Task
from planner.learned.checkpoint import CHECKPOINTS
from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import Moments, PlannerNetwork
from planner.one_thread import one_thread
from planner.policy_setup import PolicySetup
from planner.seen.done import is_low
from planner.seen.due import due
from planner.seen.room import RoomSeen
from planner.seen.sight import UNSEEN, Sight
from planner.seen.standstill import STANDSTILL, Standstill
from planner.seen.task_clock import TaskClock
from planner.task import GRAB
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.rest_frame import RestFrame

FLAG_ABOVE = 0.5  # probability that a correction is needed; assumed
MOST_CORRECTIONS = 3  # among the remembered moments; assumed
SURE = 0.7  # probability from which another task is given at once; assumed


class _Moment(NamedTuple):
    """When the planner was asked, what it saw, and which instruction was in force."""

    time_s: float
    vector: NDArray[np.float32]
    task: int
    correction: int
    since_s: float


class PlannerLearned:
    """Gives the instruction that the network predicts from the last moments.

    It changes the task when the network is sure of another one, or still prefers it a second
    later: a late change costs that second, an early one leaves the task undone. What is seen to be
    done, or not, decides which tasks may be due (`due`). Corrections that have not helped for some
    seconds make room for the task itself. After the first cut it never grasps again: the tubes can
    no longer be spread. How many clips a tube gets follows from its length as it was seen before
    anything pulled at it. It calls for a person where the tubes have no room (`RoomSeen`) or are
    not seen well (`Sight`), where the arms stand still, and where a clip or a cut would be tried
    for the fourth time. It raises an alarm where a task's chance of failure is high twice in a row.

    With `alone`, any task may be due that its network asks for, to measure what `due` is worth; the
    rest is as above.
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
        self._room, self._sight, self._standstill = RoomSeen(), Sight(), Standstill()

    def plan(self, observation: Observation) -> Instruction:
        """Return the task that should be given now, with a correction if one is needed."""
        self._remember(observation)
        self._standstill.see(observation)
        self._sight.see(observation)
        self._room.see(observation)
        with torch.inference_mode(), one_thread():
            opinion = self._network(self._stacked())
            fails = self._network.failure_chance(opinion).item()
        chances = self._chances(opinion.task[0], observation)
        self._take_up(chances)
        task = TASKS[self._task]
        if (why := self._why_call(task, observation)) is not None:
            return Instruction(
                task=task, hold=True, call=True, remark=why, time_s=observation.time_s
            )
        uneasy, self._uneasy = self._uneasy, fails > self._network.alarm.item()
        given = sum(moment.correction != N_CORRECTIONS for moment in self._moments)
        flagged = opinion.flag.sigmoid().item() > FLAG_ABOVE and given < MOST_CORRECTIONS
        wanted = flagged and not (task == GRAB and is_low(observation))  # its jaws open first
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

    def _why_call(self, task: Task, observation: Observation) -> str | None:
        """Return why a person must be called now; None if there is no reason."""
        if self._standstill.lasts:
            return STANDSTILL
        if self._sight.is_lost:
            return UNSEEN
        if self._tries[self._task] > MOST_TRIES:
            return failed_too_often(task)
        return self._room.why_call(observation, due=task.is_deed)

    def _remember(self, observation: Observation) -> None:
        """Add a moment."""
        self._clock.see(observation)
        seen, since_s = self._frame.follow(observation.vector()), self._clock.since_s
        self._moments.append(
            _Moment(observation.time_s, seen, self._task, self._correction, since_s)
        )

    def _chances(self, logits: torch.Tensor, observation: Observation) -> torch.Tensor:
        """Return the probability of each task that may be due.

        What is asked for where another task is due counts for that one, unless the network decides
        alone. After a cut nothing is grabbed, even if a person ordered it.
        """
        if self._has_cut or observation.severed.any():
            logits = logits.index_fill(0, torch.tensor(GRAB.index - 1), -torch.inf)
        chances = logits.softmax(dim=-1)
        if self._alone:
            return chances
        given = TASKS[self._task] if self._task < N_TASKS else None
        owed = [due(asked, given, observation, self._clock).index - 1 for asked in TASKS]
        return torch.zeros_like(chances).index_add(0, torch.tensor(owed), chances)

    def _take_up(self, chances: torch.Tensor) -> None:
        task = int(chances.argmax())
        sure = chances[task] >= SURE or task == self._preferred or self._task == N_TASKS
        self._preferred = task
        if sure and task != self._task:
            self._task, self._uneasy = task, False
            self._clock.begin()
            self._tries[task] += TASKS[task].is_deed
            self._has_cut |= TASKS[task].kind == "go_back_from_cut"

    def _stacked(self) -> Moments:
        """Return the remembered moments; copies of the first, marked unknown, fill the start."""
        missing = self._network.config.history - len(self._moments)
        rows = [self._moments[0]] * missing + list(self._moments)
        return Moments(
            frames=torch.from_numpy(np.stack([row.vector for row in rows]))[None],
            known=(torch.arange(len(rows)) >= missing)[None],
            task=torch.tensor([[row.task for row in rows]]),
            correction=torch.tensor([[row.correction for row in rows]]),
            since_s=torch.tensor([[row.since_s for row in rows]]),
        )


def load_planner(checkpoint: str | Path | None = None, *, alone: bool = False) -> PlannerLearned:
    """Return the planner of a checkpoint, by default the one shipped with Calot.

    Raises:
        CheckpointError: there is no checkpoint, or it does not fit.
    """
    return PlannerLearned(CHECKPOINTS.load(checkpoint), alone=alone)


def make(setup: PolicySetup) -> PlannerLearned:
    """Return the planner of the checkpoint in its setup.

    Raises:
        CheckpointError: there is none, or it does not fit.
    """
    return load_planner(setup.checkpoint)


def make_alone(setup: PolicySetup) -> PlannerLearned:
    """Return the planner of the checkpoint in its setup, whose network decides alone on tasks.

    Raises:
        CheckpointError: there is none, or it does not fit.
    """
    return load_planner(setup.checkpoint, alone=True)
