"""Represent recorded episodes as training data of the planner, with the moments in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from planner.base import PLANNING_PERIOD_S
from planner.learned.features import N_CORRECTIONS, N_TASKS
from planner.learned.network import Moments
from planner.procedure.cholecystectomy import TASKS
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.sensing.rest_frame import at_rest, fixed_m

EVERY = round(PLANNING_PERIOD_S * CONTROL_HZ)  # control steps between moments
ASKED_EVERY = (20, EVERY + 1)  # the same in training; more often after tools were exchanged
IN_TIME_S = 10.0  # a task that has not succeeded by then counts as failed
NOT_SAID = -1


@dataclass(frozen=True, kw_only=True)
class Rollout:
    """One episode, step by step, with any controller.

    Attributes:
        states: (n, `VECTOR_SIZE`) observations, as `Observation.vector()`.
        said: (n,) the task that was given, 0 to 16.
        corrected: (n,) the correction that was given, 0 to 17, or -1.
        task: (n,) the task that should have been given, 0 to 16.
        correction: (n,) the correction that should have been given, 0 to 17, or -1.
        success: Whether the last task succeeded too.
        declined: Whether the patient must be left to a person before the first clip.
        learned: Whether a learned controller moved the arms, not the expert.
        patient: The patient's seed. Several rollouts may be of one episode, sensed with other
            errors.

    Raises:
        ValueError: Lengths differ, or there is no step.
    """

    states: NDArray[np.float32]
    said: NDArray[np.int64]
    corrected: NDArray[np.int64]
    task: NDArray[np.int64]
    correction: NDArray[np.int64]
    success: bool
    declined: bool = False
    learned: bool = False
    patient: int = 0

    def __post_init__(self) -> None:
        lengths = {
            len(column)
            for column in (self.states, self.said, self.corrected, self.task, self.correction)
        }
        if len(lengths) != 1 or lengths == {0}:
            raise ValueError(f"rollout: columns must be as long as each other, got {lengths}")

    @property
    def digest(self) -> bytes:
        """Return the digest of the training data, without the patient and the acting controller."""
        columns = (self.states, self.said, self.corrected, self.task, self.correction)
        flags = bytes([self.success, self.declined])
        return sha256(b"".join(c.tobytes() for c in columns) + flags).digest()


class Labels(NamedTuple):
    """The targets of `Prediction`.

    Attributes:
        correction: (B,) the needed correction, -1 where none is needed.
        fails: (B,) 1, 0, or NaN where the episode ends before the outcome is known.
        calls: (B,) 1 where a person must be called, else 0.
    """

    task: Tensor
    correction: Tensor
    progress: Tensor
    fails: Tensor
    calls: Tensor


class MomentBatch(NamedTuple):
    """All steps of all rollouts, end to end."""

    states: Tensor
    said: Tensor
    corrected: Tensor
    since_s: Tensor
    tries: Tensor
    begin: Tensor
    labels: Labels


class Rollouts:
    """Rollouts end to end in memory, and the moments in them.

    Attributes:
        digest: Digest of all training data, in hex.
        changes: Steps up to a second after the right task has changed.
        flagged: Steps in which a correction is needed.
        declined: Steps of patients who must be left to a person.

    Raises:
        ValueError: There is no rollout.
    """

    def __init__(self, rollouts: Sequence[Rollout], history: int) -> None:
        if not rollouts:
            raise ValueError("rollouts: there is none, nothing to learn from")
        self._history = history
        self.digest = sha256(b"".join(r.digest for r in rollouts)).hexdigest()
        lengths = torch.tensor([len(r.task) for r in rollouts])
        begins = torch.cumsum(lengths, 0) - lengths
        self.steps = MomentBatch(
            states=_joined([at_rest(r.states, fixed_m(r.states[0])) for r in rollouts]),
            said=_joined([r.said for r in rollouts]),
            corrected=_joined([r.corrected for r in rollouts]),
            since_s=_joined([_since_s(r.said) for r in rollouts]),
            tries=_joined([_tries(r.said) for r in rollouts]),
            begin=torch.repeat_interleave(begins, lengths),
            labels=Labels(*(_joined(part) for part in zip(*map(_labels, rollouts), strict=True))),
        )
        self.changes = _joined([_just_changed(r.task) for r in rollouts]).nonzero()[:, 0]
        self.flagged = (self.steps.labels.correction != NOT_SAID).nonzero()[:, 0]
        self.declined = self.steps.labels.calls.nonzero()[:, 0]

    def __len__(self) -> int:
        return len(self.steps.said)

    def moments(self, at: Tensor, every: Tensor, lag: Tensor) -> Moments:
        """Return moments (B, H) up to steps `at` (B,), in which words are `lag` (B,) steps old.

        The moments of a row are `every` (B,) steps apart.
        """
        data = self.steps
        back = torch.arange(self._history - 1, -1, -1)
        rows, begin = at[:, None] - back * every[:, None], data.begin[at, None]
        known, rows = rows >= begin, torch.maximum(rows, begin)
        heard, any_heard = rows - lag[:, None], rows - lag[:, None] >= begin
        heard = torch.maximum(heard, begin)
        corrected = data.corrected[heard]
        return Moments(
            frames=data.states[rows],
            known=known,
            task=torch.where(any_heard, data.said[heard], N_TASKS),
            correction=torch.where(any_heard & (corrected >= 0), corrected, N_CORRECTIONS),
            since_s=torch.where(any_heard, data.since_s[heard] + lag[:, None] / CONTROL_HZ, 0.0),
            tries=torch.where(any_heard, data.tries[heard], 0),
        )

    def labels(self, at: Tensor) -> Labels:
        """Return the targets at steps (B,)."""
        return Labels(*(part[at] for part in self.steps.labels))

    def tasks(self, at: Tensor) -> Sequence[Tensor]:
        """Return the rows of steps `at` (B,) of each task of each rollout, one after the other."""
        runs = torch.stack([self.steps.begin[at], self.steps.labels.task[at]])
        starts = (runs[:, 1:] != runs[:, :-1]).any(dim=0).nonzero()[:, 0] + 1
        return torch.tensor_split(torch.arange(len(at)), starts)


def _labels(rollout: Rollout) -> Labels:
    n, (starts, ends) = len(rollout.task), _runs(rollout.task)
    lengths, done = ends - starts, _done_by(rollout.task[starts], ends)
    start, end = np.repeat(starts, lengths), np.repeat(done, lengths)
    left_s = (end - np.arange(n)) / CONTROL_HZ
    unknown = (end == n) & (not rollout.success) & (left_s < IN_TIME_S)
    fails = (left_s >= IN_TIME_S).astype(float)
    return Labels(
        task=torch.from_numpy(rollout.task),
        correction=torch.from_numpy(rollout.correction),
        progress=torch.from_numpy((np.arange(n) - start) / (end - start)).float(),
        fails=torch.from_numpy(np.where(unknown, np.nan, fails)).float(),
        calls=torch.full((n,), float(rollout.declined)),
    )


def _runs(said: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the begins and ends of runs of equal values."""
    starts = np.flatnonzero(np.diff(said, prepend=NOT_SAID))
    return starts, np.append(starts[1:], len(said))


def _done_by(tasks: NDArray[np.int64], ends: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the end of each run, or of its last repetition if only retractions lie between."""
    done = ends.copy()
    for k in reversed(range(len(tasks) - 2)):
        if tasks[k + 2] == tasks[k] and TASKS[tasks[k + 1]].goes_back:
            done[k] = done[k + 2]
    return done


def _since_s(said: NDArray[np.int64]) -> NDArray[np.float32]:
    starts, ends = _runs(said)
    return ((np.arange(len(said)) - np.repeat(starts, ends - starts)) / CONTROL_HZ).astype(
        np.float32
    )


def _tries(said: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many times the task in force has been given so far."""
    starts, ends = _runs(said)
    given, times = said[starts], np.zeros(len(starts), np.int64)
    for task in np.unique(given):
        runs = given == task
        times[runs] = 1 + np.arange(runs.sum())
    return np.repeat(times, ends - starts)


def _just_changed(task: NDArray[np.int64]) -> NDArray[np.bool_]:
    return (_since_s(task) < 1.0) & (np.arange(len(task)) >= CONTROL_HZ)


def _joined(columns: Sequence[NDArray | Tensor]) -> Tensor:
    return torch.cat([torch.as_tensor(column) for column in columns])
