"""Made-up motions for tests: tools wander, turn and open; some frames must not be imitated."""

import numpy as np
import torch

from controller.action import ToolAction
from controller.dataset.schema import UNNAMED
from controller.diffusion.chunk_frame import JAW, relative, trajectory
from controller.diffusion.command import NONE
from controller.diffusion.windows import DemonstrationArrays
from planner.instruction import TASKS, task_from_text
from tissue_sim.frames import Array, exponential, rotation_to_6d
from tissue_sim.sensing.observation import VECTOR_SIZE, fields

FIRST_CLIPS = [task_from_text(f"clipping first clip {side} tube") for side in ("left", "right")]


def motions(n: int, seed: int = 0) -> np.ndarray:
    """Return random motions (n, 20) of a plausible size."""
    chance = np.random.default_rng(seed)
    return np.stack(
        [
            ToolAction(
                move_endoscope_m=chance.normal(scale=1e-3, size=(2, 3)),
                turn_tool=np.stack(
                    [rotation_to_6d(exponential(v)) for v in chance.normal(scale=0.04, size=(2, 3))]
                ),
                jaw_rad=chance.uniform(-0.3, 1.0, size=2),
            ).vector()
            for _ in range(n)
        ]
    )


def chunk_of(actions: Array) -> Array:
    """Return the chunk (n, 20) of motions (n, 20), as a policy predicts it."""
    rows = torch.as_tensor(actions, dtype=torch.float64)
    poses = trajectory(rows)
    return relative(poses[0], poses[1:], rows.reshape(-1, 2, 10)[..., JAW]).numpy()


def demonstration(n: int = 120, seed: int = 0) -> DemonstrationArrays:
    """Return a demonstration: the right tip moves to the first point of the named tube."""
    chance = np.random.default_rng(seed)
    states, actions = np.zeros((n, VECTOR_SIZE), np.float32), motions(n, seed).astype(np.float32)
    seen = fields(states)
    seen["tips_endoscope"][..., :3] = np.eye(3)
    seen["tubes_m"][:] = chance.normal(scale=0.01, size=seen["tubes_m"].shape)
    told_left = np.arange(n) < n // 2
    named = np.where(
        told_left[:, None],
        seen["tubes_m"][:, 0, 0],
        seen["tubes_m"][:, 1, 0],
    )
    actions[:, 10:13] = 0.1 * (named - seen["tips_endoscope"][:, 1, :, 3])
    return DemonstrationArrays(
        states=states,
        actions=actions,
        task=np.where(told_left, *(TASKS.index(task) for task in FIRST_CLIPS)),
        correction=np.full(n, NONE),
        left=np.full((n, 2), UNNAMED, np.float32),
        expert=np.arange(n) % 40 != 39,
        free=np.zeros((n, 2), bool),
        near=np.zeros((n, 2), bool),
    )
