"""The scrub nurse: exchanges and reloads the right arm's tool, as a person does in SRT-H.

The arm straightens as it goes back through its port, gets what the next task needs, and waits where
it was at the start. Policies pause meanwhile, and the time is counted separately.
"""

from __future__ import annotations

from collections.abc import Iterator

from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation, tip_to_tubes_m
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, JointCommand
from tissue_sim.world import World

JAW = 6
OUT_INSERTION_M = 0.05  # assumed: the tip is outside the field
ROOM_M = 0.012  # assumed: less than the distance to which arms go back
EXCHANGE_S = 0.8  # one way, assumed; a person takes longer, which is not studied here


def is_needed(seen: Observation, tool: str, *, clip: bool) -> bool:
    """Return whether the right arm lacks the tool, or a clip to place."""
    if seen.tools[RIGHT_ARM] != tool:
        return True
    return clip and not seen.clip_loaded


def has_room(seen: Observation) -> bool:
    """Return whether the right tip is so far from both tubes that its tool can be drawn out."""
    return tip_to_tubes_m(seen) >= ROOM_M


def exchange(world: World, tool: str, joints: Array) -> Iterator[JointCommand]:
    """Yield joint targets, one for each control step, from commanded joints (2, 7) to home.

    The jaws stay as they are. A bent wrist that is drawn straight out of the field, or a longer
    tool that returns to where the other one was, could hit the other arm.
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
