"""Does every clip hold a pull of 1 N, along its tube and across it? The test is at the end.

A vessel that is too thin for this pull is pulled by less than tears it.

As in a laboratory, the vessel is clamped beside the clip, on the side away from the cut. The clip
is pulled towards the cut end. The clamp takes the reaction, so that nothing else is pulled.
"""

from __future__ import annotations

import numpy as np

from tissue_sim.outcome.predicates import required_pull_n
from tissue_sim.patient.tubes import Crossing
from tissue_sim.surgery.clip import Clip, T_world_clip
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

PULL_S = (0.25, 0.15, 0.25)  # increase, hold, decrease: as slowly as a test machine
CLAMP_RINGS = 2  # rings between clip and clamp


def pull_all_clips(world: World) -> None:
    """Pull each clip in turn. The record then shows which clips slip or detach, or what tears."""
    for clip in world.record.clips:
        for crossing in clip.crossings:
            away = _towards_cut(world, crossing)
            _, along = world.tubes.point(crossing.tube, crossing.station_m)
            pull_n = required_pull_n(world.tubes, crossing.tube)
            for direction in (away * along, T_world_clip(world.tubes, clip)[:3, 1]):
                _pull(world, clip, crossing, pull_n * direction, away)


def _towards_cut(world: World, crossing: Crossing) -> int:
    """Return +1 when the cut lies further up the tube than the clip, else -1."""
    cuts = [c.station_m for c in world.record.cuts if c.tube == crossing.tube]
    return 1 if not cuts or cuts[0] > crossing.station_m else -1


def _pull(
    world: World, clip: Clip, crossing: Crossing, force_world_n: np.ndarray, away: int
) -> None:
    rings = world.tubes.below[crossing.tube]
    clamp = rings[int(np.clip(crossing.ring - away * CLAMP_RINGS, 0, len(rings) - 1))]
    hold = JointCommand(joints=world.target)
    up, steady, down = (round(t / world.config.control_step_s) for t in PULL_S)
    for share in (*np.linspace(0, 1, up + 1)[1:], *np.ones(steady), *np.linspace(1, 0, down + 1)):
        world.pull_clip(clip.number, share * force_world_n, clamp)
        world.step(hold)
