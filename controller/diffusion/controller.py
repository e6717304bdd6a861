"""The diffusion policy as a controller: it sees observations and hears words, nothing else."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.action import ACTION_SIZE, Chunk, hold
from controller.diffusion.body_frame import BodyFrame
from controller.diffusion.checkpoint import SHIPPED, load_checkpoint
from controller.diffusion.chunk_frame import JAWS, actions_of, motion_of, past_of
from controller.diffusion.config import PolicyConfig
from controller.diffusion.dead_time import MAX_STEPS, DeadTime, foreseen
from controller.diffusion.graph import Sampler
from planner.instruction import Instruction
from planner.language.sentence_encoder import embed
from planner.learning.checkpoint import chosen
from planner.policy_setup import PolicySetup
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation, fields

FADE = 4  # motions over which a new chunk takes over from the running one


class ControllerDiffusion:
    """Hands out one motion at a time, so that it sees every control step.

    The next chunk takes over when `play` motions of the running one have been played. It is worked
    out from what was seen `delay` steps before, as if that took so long, and given the motions that
    lead up to it, of which as many were not yet played then; its first motions are mixed with what
    the running one had still to play, which makes accelerations at joints those inside chunks. New
    words drop the running chunk, and the next one follows at once on what was played. All of it is
    in a frame that goes along with the body (`body_frame`); where motions are seen to come late
    (`dead_time`), tools are taken to be where they were asked to go already.

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
        self._body, self._dead_time = BodyFrame(), DeadTime()
        self.reset()

    def reset(self) -> None:
        """Forget what was seen and is under way; not the robot's delay, nor where the body lay."""
        self._seen: deque[NDArray[np.float32]] = deque(maxlen=max(self._config.history) + 1)
        self._played: deque[Array] = deque(maxlen=self._config.past + MAX_STEPS + 1)
        self._body.reset()
        self._dead_time.reset()
        self._drop()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """The next motion alone."""
        seen = self._body.see(observation.vector())
        self._seen.append(seen)
        self._dead_time.see(fields(seen)["tips_endoscope"][..., 3])
        text = self._config.heard(instruction.text)
        if text != self._text:
            self._drop()
            self._text = text
        fresh = not len(self._running)
        if fresh:
            self._compute_chunk(observation, n_committed=0)
        elif self._n_played == self._config.play - self._delay:
            self._compute_chunk(observation, n_committed=self._delay)
        self.place = "fresh" if fresh else "inside" if self._n_played else "joint"
        row, self._running = self._running[0], self._running[1:]
        self._n_played += 1
        self._played.append(row)
        self._dead_time.ask(row)
        return (motion_of(self._body.along(row)),)

    def _drop(self) -> None:
        self.place, self._text = "fresh", ""
        self._running: Array = np.empty((0, ACTION_SIZE))

    def _compute_chunk(self, observation: Observation, n_committed: int) -> None:
        """Let a new chunk follow on the motions committed."""
        committed, rest = np.split(self._running, [n_committed])
        if not self._played:
            self._played.append(hold(observation.joints[:, 6]).vector())
        rows = np.concatenate([self._played, committed])[-self._config.past - 1 :]
        jaws_rad = rows[:, JAWS]
        past = np.zeros((self._config.past, ACTION_SIZE), np.float32)
        past[len(past) - len(rows) + 1 :] = past_of(rows[1:], jaws_rad[0])
        shape = (self._config.horizon, ACTION_SIZE)
        chunk = self._sampler(
            {
                "history": self._history(),
                "jaw_rad": jaws_rad[-1].astype(np.float32),
                "words": embed(self._text).numpy(),
                "past": past,
                "n_past": np.array(len(rows) - 1),
                "delay": np.array(n_committed),
                "noise": self._chance.standard_normal(shape, np.float32),
            }
        )
        self._running = np.concatenate([committed, _faded(rest, actions_of(chunk.astype(float)))])
        self._n_played = -n_committed  # motions of this chunk

    def _history(self) -> NDArray[np.float32]:
        newest = len(self._seen) - 1
        return np.stack([self._foreseen(min(ago, newest)) for ago in self._config.history])

    def _foreseen(self, ago: int) -> NDArray[np.float32]:
        """What was seen `ago` steps before, with the tools where they were asked to go by then."""
        seen, late = self._seen[-1 - ago], self._dead_time.steps
        rows = list(self._played)[: len(self._played) - ago][-late - 1 :]
        return foreseen(seen, np.stack(rows)) if late and rows else seen


def _faded(old: Array, new: Array) -> Array:
    """Motions (n, 20) of a chunk that takes over from another's (m, 20) within `FADE` of them."""
    n = min(len(old), FADE)
    share, rows = np.arange(1, n + 1)[:, None] / (n + 1), new.copy()
    rows[:n] = (1.0 - share) * old[:n] + share * new[:n]
    return rows


def load_controller(checkpoint: str | Path | None = None, seed: int = 0) -> ControllerDiffusion:
    """The controller of a checkpoint, by default the one that comes with Calot.

    Raises:
        CheckpointError: there is none, or it does not fit.
    """
    policy = load_checkpoint(chosen(checkpoint, SHIPPED, "controller"))
    return ControllerDiffusion(policy.config, Sampler(policy), seed)


def make(setup: PolicySetup) -> ControllerDiffusion:
    """Return the controller of the checkpoint in its setup.

    Raises:
        CheckpointError: there is none, or it does not fit.
    """
    return load_controller(setup.checkpoint, setup.seed)
