"""The diffusion policy as a controller: it sees observations and hears words, nothing else."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.action import ACTION_SIZE, Chunk
from controller.diffusion.checkpoint import chosen, load_checkpoint
from controller.diffusion.chunk_frame import actions_of, chunk_of, motion_of
from controller.diffusion.config import PolicyConfig
from controller.diffusion.graph import Sampler
from controller.diffusion.sentence_encoder import embed
from planner.instruction import Instruction
from tissue_sim.frames import Array
from tissue_sim.observation import Observation


class ControllerDiffusion:
    """Hands out one motion at a time, so that it sees every control step.

    The next chunk takes over when `play` motions of the running one have been played. It is worked
    out from what was seen `delay` steps before, as if that took so long, and given the motions that
    are played meanwhile. New words drop the running chunk, and the next one starts from nothing.

    Attributes:
        place: of the motion handed out last: the first of a "fresh" chunk or, at a "joint", of one
            that took over from another, or "inside" a chunk.
    """

    def __init__(
        self, config: PolicyConfig, sampler: Sampler, seed: int = 0, delay: int = 0
    ) -> None:
        if not 0 <= delay <= config.max_delay:
            raise ValueError(f"delay must be 0 to {config.max_delay} control steps, got {delay}")
        self._config, self._sampler, self._delay = config, sampler, delay
        self._chance = np.random.default_rng(seed)
        self.reset()

    def reset(self) -> None:
        """Forget what was seen and what was under way."""
        self._seen: deque[NDArray[np.float32]] = deque(maxlen=max(self._config.history) + 1)
        self._jaw_rad: Array | None = None
        self._drop()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """The next motion alone."""
        self._seen.append(observation.vector())
        if instruction.text != self._text:
            self._drop()
            self._text = instruction.text
        fresh = not len(self._running)
        if fresh:
            self._compute_chunk(observation, n_committed=0)
        elif self._played == self._config.play - self._delay:
            self._compute_chunk(observation, n_committed=self._delay)
        self.place = "fresh" if fresh else "inside" if self._played else "joint"
        motion, self._running = motion_of(self._running[0]), self._running[1:]
        self._played += 1
        self._jaw_rad = motion.jaw_rad
        return (motion,)

    def _drop(self) -> None:
        self.place, self._text = "fresh", ""
        self._running: Array = np.empty((0, ACTION_SIZE))

    def _compute_chunk(self, observation: Observation, n_committed: int) -> None:
        """Let a new chunk follow on the motions committed."""
        c = self._config
        committed = self._running[:n_committed]
        given = np.zeros((c.horizon, ACTION_SIZE), np.float32)
        given[:n_committed] = chunk_of(committed)
        jaw_rad = observation.joints[:, 6] if self._jaw_rad is None else self._jaw_rad
        chunk = self._sampler(
            {
                "history": self._history(),
                "jaw_rad": jaw_rad.astype(np.float32),
                "words": embed(self._text).numpy(),
                "committed_chunk": given,
                "n_committed": np.array(n_committed, np.int64),
                "noise": self._chance.standard_normal(given.shape, np.float32),
            }
        )
        self._running = np.concatenate([committed, actions_of(chunk.astype(float))[n_committed:]])
        self._played = -n_committed  # motions of this chunk

    def _history(self) -> NDArray[np.float32]:
        newest = len(self._seen) - 1
        return np.stack([self._seen[max(newest - ago, 0)] for ago in self._config.history])


def load_controller(checkpoint: str | Path | None = None, seed: int = 0) -> ControllerDiffusion:
    """The controller of a checkpoint, by default the one that comes with Calot.

    Raises:
        CheckpointError: there is none, or it does not fit.
    """
    policy = load_checkpoint(chosen(checkpoint))
    return ControllerDiffusion(policy.config, Sampler(policy), seed)
