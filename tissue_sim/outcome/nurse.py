"""Act as the scrub nurse: exchange and reload the right arm's tool, as a person does in SRT-H.

The arm straightens while it retracts through its port. It gets the tool or clip for the next task,
and then waits at its start pose. Policies pause meanwhile, and the time is counted separately.
"""

from __future__ import annotations

from collections.abc import Iterator

from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation, tip_to_tubes_m
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.world import World

JAW = 6
OUT_INSERTION_M = 0.05  # assumed: here the tip is outside the field
ROOM_M = 0.012  # assumed: less than the distance to which arms retract
EXCHANGE_S = 0.8  # one way, assumed; a person takes longer, which is not studied


def is_needed(observation: Observation, tool: str, *, clip: bool) -> bool:
    """Return whether the right arm lacks the chosen tool, or lacks a clip to place."""
    if observation.tools[RIGHT_ARM] != tool:
        return True
    return clip and not observation.clip_loaded


def has_room(observation: Observation) -> bool:
    """Return whether the right tip is far enough from both tubes to exchange its tool."""
    return tip_to_tubes_m(observation) >= ROOM_M


def exchange(world: World, tool: str, joints: Array) -> Iterator[JointCommand]:
    """Yield joint targets, one for each control step, from commanded joints (2, 7) to home.

    The jaws keep their opening. The arm straightens on the way out, because a bent wrist could hit
    the other arm. It returns to home, because a longer tool at the earlier tool's pose could hit
    the other arm too.
    """
    steps = round(EXCHANGE_S / world.config.control_step_s)
    home = joints.copy()
    home[RIGHT_ARM, :JAW] = HOME_JOINTS[:JAW]
    there = home.copy()
    there[RIGHT_ARM, 2] = min(OUT_INSERTION_M, joints[RIGHT_ARM, 2])
    for k in range(steps):
        yield _between(joints, there, (k + 1) / steps)
    world.equip(tool)
    there, home = world.arms.limited(there), world.arms.limited(home)
    for k in range(steps):
        yield _between(there, home, (k + 1) / steps)


def _between(start: Array, end: Array, share: float) -> JointCommand:
    smooth = share * share * (3.0 - 2.0 * share)
    return JointCommand(joints=start + smooth * (end - start))
