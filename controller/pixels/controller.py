"""Run the policy from pixels as a controller that gets pictures, encoders and commands only."""

from __future__ import annotations

import numpy as np
import torch

from controller.action import ACTION_SIZE, Chunk, hold
from controller.diffusion.chunk_frame import actions_of, given_past, motion_of
from controller.diffusion.command import encoded
from controller.pixels.policy import CHECKPOINTS, PixelPolicy
from planner.instruction import Instruction
from planner.learning.networks import kept
from planner.policy_setup import PolicySetup
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation

_loaded = kept(CHECKPOINTS.load)


class ControllerPixels:
    """Plays the first motions of each chunk, then observes again.

    Neither perceived points nor rules on them influence the chunks.
    """

    def __init__(self, policy: PixelPolicy, seed: int = 0) -> None:
        self._policy = policy
        self._chance = np.random.default_rng(seed)
        self.reset()

    def reset(self) -> None:
        """Forget the earlier motions and the rest of the chunk."""
        self._rows: Array | None = None
        self._asked_s = 0.0

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the next motions."""
        config, rows = self._policy.config, self._played(observation)
        noise = self._chance.standard_normal((config.horizon, ACTION_SIZE), np.float32)
        given = given_past(rows, config.past) | {
            "pictures": self._pictures(observation),
            "state": observation.vector(),
            **encoded(instruction, config),
            "noise": noise,
        }
        with torch.inference_mode():
            chunk = self._policy(**{k: torch.as_tensor(v)[None] for k, v in given.items()})[0]
        motions = actions_of(chunk.numpy().astype(float))[: config.play]
        self._rows, self._asked_s = np.concatenate([rows, motions]), observation.time_s
        return tuple(motion_of(row) for row in motions)

    def _played(self, observation: Observation) -> Array:
        """Return the earlier motions (n, 20), without dropped motions of the last chunk."""
        if self._rows is None:
            return hold(observation.joints[:, 6]).vector()[None]
        n = round((observation.time_s - self._asked_s) / CONTROL_PERIOD_S)
        dropped = max(self._policy.config.play - n, 0)
        return self._rows[-self._policy.config.past - 1 - dropped : len(self._rows) - dropped]

    def _pictures(self, observation: Observation) -> np.ndarray:
        pixels = self._policy.pixels
        return np.stack([pixels.shrunk(observation.images[name]) for name in pixels.cameras])


def make(setup: PolicySetup) -> ControllerPixels:
    """Return the controller of the checkpoint in its setup.

    Raises:
        CheckpointError: There is no checkpoint, or the checkpoint does not fit.
        ValueError: A camera is missing.
    """
    policy = _loaded(CHECKPOINTS.chosen(setup.checkpoint))
    setup.require_cameras("pixels", policy.pixels.cameras)
    return ControllerPixels(policy, setup.seed)
