"""Give the two kinds of clip, and their appliers, short names."""

from tissue_sim.tools.clips import CLIPS, MEDIUM_LARGE_POLYMER, MEDIUM_TITANIUM
from tissue_sim.tools.instruments import applier_of

POLYMER, TITANIUM = CLIPS[MEDIUM_LARGE_POLYMER], CLIPS[MEDIUM_TITANIUM]
APPLIER, SLIM_APPLIER = applier_of(POLYMER), applier_of(TITANIUM)
