"""Made-up observations: the right jaws at a station of a straight duct, which has clips."""

import numpy as np
from numpy.typing import NDArray

from tests.tissue_sim.kinds import POLYMER, SLIM_APPLIER
from tissue_sim.outcome.clip_rule import clip_stations_m
from tissue_sim.sensing.observation import TUBE_POINTS, VECTOR_SIZE, fields
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import CLIP_APPLIER, SCISSORS, right_tools

LENGTH_M = 0.019
RULE_M = [float(s) for s in clip_stations_m("duct", np.array(LENGTH_M), SLIM_APPLIER)]


def seen(
    station_m: float, *clips_m: float, beside_m: float = 0.0, scissors: bool = False
) -> NDArray[np.float32]:
    """Return what is seen: jaws at a station of the left tube, the duct, which has clips.

    Tubes point up (+y), the tool ahead (+z).
    """
    vector = np.zeros(VECTOR_SIZE, np.float32)
    now = fields(vector)
    y = np.linspace(0.0, LENGTH_M, TUBE_POINTS)
    for k, x in enumerate((0.0, -0.02)):
        now["tubes_m"][k] = np.stack([np.full_like(y, x), y, np.full_like(y, 0.09)], axis=1)
    now["sac_m"][0] = now["tubes_m"][0, -1]
    now["rest_length_m"][:] = LENGTH_M
    now["tips_endoscope"][..., :3] = np.eye(3)
    now["tips_endoscope"][RIGHT_ARM, :, 3] = beside_m, station_m, 0.09 + 0.5 * POLYMER.length_m
    for k, clip_m in enumerate(clips_m):
        now["clips_m"][k] = 0.0, clip_m, 0.09
    now["n_clips"][:] = len(clips_m)
    tool = SCISSORS if scissors else CLIP_APPLIER
    now["right_tool"][right_tools().index(tool)] = 1.0
    now["clip_loaded"][:] = not scissors
    return vector
