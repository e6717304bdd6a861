"""Cut demonstrations into the windows that a policy is trained on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from controller.action import ACTION_SIZE
from controller.dataset.schema import UNNAMED
from controller.diffusion.chunk_frame import JAW, relative, trajectory
from controller.diffusion.command import NONE
from controller.diffusion.config import PolicyConfig
from planner.correction import CORRECTIONS
from tissue_sim.sensing.observation import VECTOR_SIZE, fields

Floats = NDArray[np.float32]
CORRECTED = 0.4  # share of balanced windows; assumed


@dataclass(frozen=True, kw_only=True)
class DemonstrationArrays:
    """A run of control steps without a tool exchange.

    Attributes:
        states: (n, `VECTOR_SIZE`) `Observation.vector()` before each motion.
        actions: (n, 20) motions, each a `ToolAction.vector`.
        task: (n,) rows of `TASKS`.
        correction: (n,) rows of `CORRECTIONS`, or `command.NONE`.
        left: (n, 2) the distance, m, and the opening of the jaws, rad, that are left of the
            correction; `UNNAMED` where none was named.
        expert: (n,) whether the motion may be imitated.
        free: (n, 2) whether the left and the right tool touch nothing.
        near: (n, 2) whether the left and the right tool are near tissue.
        begins: The first step to imitate; steps before are only its past.

    Raises:
        ValueError: Shapes differ from these, or a number is not finite.
    """

    states: Floats
    actions: Floats
    task: NDArray[np.int64]
    correction: NDArray[np.int64]
    left: Floats
    expert: NDArray[np.bool_]
    free: NDArray[np.bool_]
    near: NDArray[np.bool_]
    begins: int = 0

    def __post_init__(self) -> None:
        n = len(self.task)
        for name, shape in (
            ("states", (n, VECTOR_SIZE)), ("actions", (n, ACTION_SIZE)), ("correction", (n,)),
            ("left", (n, 2)), ("expert", (n,)), ("free", (n, 2)), ("near", (n, 2)),
        ):  # fmt: skip
            value = getattr(self, name)
            if value.shape != shape:
                raise ValueError(f"demonstration: {name} must be {shape}, got {value.shape}")
            if not np.isfinite(value).all():
                raise ValueError(f"demonstration: {name} has entries that are no finite numbers")

    @property
    def said(self) -> NDArray[np.int64]:
        """Return a number (n,) for each command, a task and a correction or none."""
        return self.task * (1 + len(CORRECTIONS)) + self.correction - NONE

    def heard_by(self, config: PolicyConfig) -> DemonstrationArrays:
        """Return the demonstration with the commands that are a policy's input."""
        if not config.wordless:
            return self
        return replace(
            self,
            task=np.zeros_like(self.task),
            correction=np.full_like(self.correction, NONE),
            left=np.full_like(self.left, UNNAMED),
        )


class Batch(NamedTuple):
    """The windows of one training step, B of them.

    Attributes:
        history: (B, K, `VECTOR_SIZE`) observed frames, the newest first.
        jaw_rad: (B, 2) jaws last commanded before the chunk.
        task, correction, left: (B,), (B,), (B, 2) the command, as in `DemonstrationArrays`.
        past: (B, P, 20) rows before the chunk, in the chunk's frame.
        n_past: (B,) number of the expert's rows of the past, the last ones; other rows do not
            count.
        delay: (B,) number of rows of the past that come after the newest frame.
        chunk: (B, H, 20) chunks in the frame of `chunk_frame`.
        valid: (B, H) rows to imitate: the expert's, under the same command; always the first rows.
        free: (B, 2) tools that touch nothing in all frames of the history.
        near: (B, 2) tools that are near tissue in the newest frame.
        newest: (B,) row of the newest frame, with demonstrations end to end.
    """

    history: Tensor
    jaw_rad: Tensor
    task: Tensor
    correction: Tensor
    left: Tensor
    past: Tensor
    n_past: Tensor
    delay: Tensor
    chunk: Tensor
    valid: Tensor
    free: Tensor
    near: Tensor
    newest: Tensor


class Windows:
    """All windows that begin with a motion to imitate, end to end in memory, on one device.

    Attributes:
        digest: Digest of the states, actions and commands, in hex; `free` and `near` do not count.

    Raises:
        ValueError: There is no window.
    """

    def __init__(
        self,
        demonstrations: Sequence[DemonstrationArrays],
        config: PolicyConfig,
        device: torch.device | str = "cpu",
    ) -> None:
        tracks = [_track(d, config) for d in demonstrations]
        if not any(track.n_valid.any() for track in tracks):
            raise ValueError("demonstrations: no motion that may be imitated, nothing to learn")
        parts = (torch.cat(part).to(device) for part in zip(*tracks, strict=True))
        self.digest = _digest(demonstrations)
        self._all, lengths = _Track(*parts), torch.tensor([len(track.task) for track in tracks])
        begins = torch.cumsum(lengths, 0) - lengths
        self._begin = torch.repeat_interleave(begins, lengths).to(device)
        self._where = self._all.n_valid.nonzero()[:, 0]
        self._balance()
        self._history = torch.tensor(config.history, device=device)
        self._behind = torch.arange(-config.past, 0, device=device)
        self._ahead = torch.arange(config.horizon, device=device)

    def _balance(self) -> None:
        correction = self._all.correction[self._where] - NONE
        self._by_correction = correction.argsort(stable=True)
        counts = torch.bincount(correction, minlength=1 + len(CORRECTIONS))
        weights = counts.double().sqrt()
        corrected = weights[1:].sum()
        weights[1:] *= CORRECTED / corrected.clamp(min=1e-9)
        weights[:1] = (1.0 - CORRECTED) * (counts[:1] > 0)
        self._weights, self._counts, self._first = weights, counts, counts.cumsum(0) - counts

    def __len__(self) -> int:
        return len(self._where)

    def some(self, n: int, chance: torch.Generator) -> Tensor:
        """Draw the numbers (n,) of windows, uniformly."""
        return torch.randint(len(self), (n,), generator=chance, device=chance.device)

    def balanced(self, n: int, chance: torch.Generator) -> Tensor:
        """Draw the numbers (n,) of windows, `CORRECTED` of them under corrections.

        A correction is drawn by the root of its number of windows, a window of it uniformly.
        """
        which = torch.multinomial(self._weights, n, replacement=True, generator=chance)
        share = torch.rand(n, generator=chance, device=chance.device, dtype=torch.float64)
        at = self._first[which] + (share * self._counts[which]).long()
        return self._by_correction[at]

    def batch(self, which: Tensor, delay: Tensor) -> Batch:
        """Return windows `which` (B,), observed `delay` (B,) steps before the chunk begins.

        The delay is limited to the time for which the command has been the same.
        """
        data, now = self._all, self._where[which]
        delay = torch.minimum(delay, data.n_committed[now])
        seen = torch.maximum((now - delay)[:, None] - self._history, self._begin[now, None])
        n_valid = data.n_valid[now, None]
        ahead = now[:, None] + torch.minimum(self._ahead, n_valid - 1)
        behind = torch.maximum(now[:, None] + self._behind, self._begin[now, None])
        return Batch(
            history=data.states[seen],
            jaw_rad=data.jaw_before[now],
            task=data.task[now],
            correction=data.correction[now],
            left=data.left[seen[:, 0]],
            past=relative(data.before[now], data.before[behind], data.jaw_before[behind]),
            n_past=data.n_past[now],
            delay=delay,
            chunk=relative(data.before[now], data.after[ahead], data.jaw[ahead]),
            valid=self._ahead < n_valid,
            free=data.free[seen].all(dim=1),
            near=data.near[seen[:, 0]],
            newest=seen[:, 0],
        )


class _Track(NamedTuple):
    """One demonstration with its commanded poses, summed once; rows are control steps."""

    states: Tensor
    before: Tensor
    after: Tensor
    jaw_before: Tensor
    jaw: Tensor
    task: Tensor
    correction: Tensor
    left: Tensor
    n_past: Tensor
    n_committed: Tensor
    n_valid: Tensor
    free: Tensor
    near: Tensor


def _track(demonstration: DemonstrationArrays, config: PolicyConfig) -> _Track:
    states = torch.from_numpy(demonstration.states)
    actions = torch.from_numpy(demonstration.actions)
    poses = trajectory(actions.double()).float()
    jaw = actions.reshape(-1, 2, 10)[..., JAW]
    said, expert = demonstration.said, demonstration.expert
    n_past, n_committed = _runs_before(expert, np.zeros_like(said)), _runs_before(expert, said)
    n_valid = np.minimum(_runs_after(expert, said), config.horizon)
    n_valid[: demonstration.begins] = 0
    return _Track(
        states=states,
        before=poses[:-1],
        after=poses[1:],
        jaw_before=torch.cat([fields(states[:1])["joints"][..., 6], jaw[:-1]]),
        jaw=jaw,
        task=torch.from_numpy(demonstration.task),
        correction=torch.from_numpy(demonstration.correction),
        left=torch.from_numpy(demonstration.left),
        n_past=torch.from_numpy(np.minimum(n_past, config.past)),
        n_committed=torch.from_numpy(np.minimum(n_committed, config.max_delay)),
        n_valid=torch.from_numpy(n_valid),
        free=torch.from_numpy(demonstration.free),
        near=torch.from_numpy(demonstration.near),
    )


def _digest(demonstrations: Sequence[DemonstrationArrays]) -> str:
    digest = sha256()
    for d in demonstrations:
        for part in (d.states, d.actions, d.expert, d.task, d.correction, d.left):
            digest.update(part.tobytes())
    return digest.hexdigest()


def _runs_after(expert: NDArray[np.bool_], said: NDArray) -> NDArray[np.int64]:
    """Return how many motions from each step on are the expert's under the same command."""
    lengths = np.zeros(len(said) + 1, np.int64)
    for t in reversed(range(len(said))):
        more = t + 1 < len(said) and said[t + 1] == said[t]
        lengths[t] = (1 + more * lengths[t + 1]) * expert[t]
    return lengths[:-1]


def _runs_before(expert: NDArray[np.bool_], said: NDArray) -> NDArray[np.int64]:
    """Return how many motions before each step were the expert's under the step's command."""
    lengths = np.zeros(len(said), np.int64)
    for t in range(1, len(said)):
        lengths[t] = (1 + lengths[t - 1]) * (expert[t - 1] and said[t] == said[t - 1])
    return lengths
