"""Define every number that decides success or injury, with its source.

`docs/physics.md` has all of them in one table.
"""

from __future__ import annotations

import numpy as np

# Clips.
CLIP_MAX_TILT_RAD = np.deg2rad(30.0)
"""Assumed: polymer clips hold when square to the vessel and fail more often at 45 deg. Source:
burst tests of the Hem-o-lok on porcine vessels, Nuffield Department of Surgical Sciences, Oxford,
publication 414045."""
CLIP_MIN_GAP_M = 0.0015
"""Assumed: the gap between neighbouring clips exceeds half a clip's width, so that legs stay
apart."""
CUFF_MIN_M = 0.001
"""Length of tissue between a clip and the cut, or a clip and a tube's end. Clips leaked or burst
where the vessel was cut flush, and held with 1 mm (the same burst tests). See also Jellison et al.,
"Comparison of Nonabsorbable Polymer Ligating and Standard Titanium Clips with and without a
Vascular Cuff"."""
LUMEN_CLOSED = 0.10
"""Assumed: largest area of the lumen over its area at rest; by Poiseuille's law this is 1 % of the
flow."""
CLIP_MAX_SLIP_M = 0.0005
"""Assumed: largest slip of a clip under a pull."""
TEST_PULL_N = 1.0
"""Assumed: every clip must hold this pull at the end."""
TEST_PULL_SHARE = 0.8
"""Assumed: on a thin vessel the pull at the end is this share of the pull that tears the vessel. An
artery of 1 mm bears about 1 N, so that the test itself would tear it."""
CLIPS_LEFT_MAX = 2
"""Assumed: number of clips that may be lost in the abdomen at once; a surgeon picks a lost clip
up."""


# Grasp.
GRASP_HOLD_S = 1.0
"""Assumed: time for which the grasp must last without a slip."""
GRASP_MAX_JAW_RAD = 0.6
"""Assumed: between wider jaws, tissue is wedged and not grasped."""
HELD_PINCH_N = 0.5
"""Assumed: with a smaller pinch the grasper touches tissue but does not hold it."""
GRASP_MIN_TRACTION_N = 0.15
"""Assumed: traction that takes up the tubes' slack."""
GRASP_MAX_SLIP_M = 0.0015
"""Assumed: largest slip of the tissue in the jaws."""
SPREAD_MIN_M = 0.004
"""Assumed: distance between the tubes' walls at mid-length."""
TAUT_MIN = 0.975
"""Assumed: a tube's end-to-end distance over its length at rest."""

# Retracting the right arm.
RETRACTED_M = 0.015
"""Assumed: distance of the right tip from the tubes."""

# Injury.
PINCH_MAX_N = 15.0
"""Pinch that damages a pig's bowel between the smallest jaws; 37 N between the largest (Heijnsdijk
et al., Surgical Endoscopy 18, 2004, p. 974-979)."""
TRACTION_MAX_N = 5.0
"""Pull at which those pinches were measured (the same paper); larger pulls were not tested."""
CRUSHED_M2 = 5e-6
"""Assumed: area of a tube, or of a fold of the gallbladder's wall, under the jaws."""
CRUSH_MAX_N = 500e3 * CRUSHED_M2
"""500 kPa over that area. Damage to bowel begins at about 500
kPa (BMJ Surgery, Interventions & Health Technologies 2021, 000084). Tips of graspers reach 210 to
650 kPa (Cartmill et al., Australian and New Zealand Journal of Surgery 69, 1999, p. 127-130)."""
MAX_STRETCH = 1.27
"""Largest stretch of a tube. Damage begins in femoropopliteal arteries of people over 50 at 1.27 +-
0.09, along the arteries (Anttila et al., Acta Biomaterialia, 2019). The same value is assumed for
the duct."""
BLUNT_MAX_N = 1.5
"""Assumed: force of the right instrument on tissue; the expert reaches 1.0 N while a clip
closes."""
PIERCED_M = 0.003
"""Depth of the right jaws in the gallbladder: a healthy wall is at most 3 mm thick (textbook value
of ultrasound)."""
LIVER_MAX_N = 2.0
"""Assumed: force of an instrument on the liver, or of tissue on the liver beyond the value at
rest."""
INSTRUMENT_CONTACT_MAX_N = 0.5
"""Assumed: force between the two arms."""
JOINT_MARGIN_RAD = 1.0e-3
"""Margin for rounding in the simulator's own limits."""
LEAK_MAX_M3 = 0.0
"""Any leak is an injury."""
TORN_MAX = 0
"""Number of broken attachments of a tube to the sac, or of the sac to the liver bed."""

# Ultimate strength.
STRENGTH_PA: dict[str, float] = dict.fromkeys(
    ("duct", "artery", "second artery", "common bile duct", "hepatic artery"), 1.4e6
)
"""Ultimate strength of a hepatic artery's wall (Phys. Med. Biol. 64, 2019, 225001, table 1, a
collection of published values). The table has no bile duct, so the ducts' strength is assumed
equal. Of the two walls in the table, the gallbladder's (2.5 MPa) and the artery's, the artery's is
the weaker."""
SAC_MAX_STRETCH = 2.0
"""Assumed: largest stretch of a patch of the gallbladder's wall, see `material`."""
