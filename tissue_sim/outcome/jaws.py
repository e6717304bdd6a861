"""Which structures lie between the right tool's jaws?"""

from __future__ import annotations

from tissue_sim.frames import Array
from tissue_sim.structures.tubes import Tubes
from tissue_sim.surgery.clips.clip import CLIP_LENGTH_M, CLIP_WIDTH_M
from tissue_sim.surgery.cut import BLADE_LENGTH_M, BLADE_WIDTH_M

GALLBLADDER = "gallbladder"
# Gap at which the judge counts the gallbladder as clipped, and one step of closing. A finger is as
# thick: the wall may press on closing fingers from outside. Tissue between them moves inwards.
SAC_HALF_GAP_M = 0.0020
MOUTHS = {  # length from the tip over which the jaws act, and their width
    "clip_applier": (CLIP_LENGTH_M, CLIP_WIDTH_M),
    "scissors": (BLADE_LENGTH_M, BLADE_WIDTH_M),
}


def between_jaws(tubes: Tubes, T_world_tool: Array, tool: str) -> frozenset[str]:
    """Return the names of the structures that the jaws would close on.

    The margin is wide enough for one step of motion before the jaws close.
    """
    reach_m, width_m = MOUTHS[tool]
    found = {t for t in tubes.organ.hollow if tubes.crossing(t, T_world_tool, reach_m)}
    if tubes.sac_between(T_world_tool, reach_m, width_m, SAC_HALF_GAP_M):
        found.add(GALLBLADDER)
    return frozenset(found)
