"""Define every number that decides success or injury, with its source."""

from __future__ import annotations

import numpy as np

# Clips: Hem-o-lok instructions for use as summarised in the reference sheet.
CLIP_MAX_TILT_RAD = np.deg2rad(30.0)
CLIP_MIN_GAP_M = 0.0015  # between neighbouring clips
CUFF_MIN_M = 0.001  # tissue between a clip and the cut, or a clip and a tube's end
LUMEN_CLOSED = 0.10  # at most: area of the lumen over its area at rest
CLIP_MAX_SLIP_M = 0.0005  # under a pull, assumed
TEST_PULL_N = 1.0  # every clip must hold this pull at the end

# Grasp.
GRASP_HOLD_S = 1.0
GRASP_MAX_JAW_RAD = 0.6  # assumed; between wider jaws, tissue is wedged and not grasped
HELD_PINCH_N = 0.5  # assumed; below it the grasper touches but does not hold
GRASP_MIN_TRACTION_N = 0.15  # assumed: enough to take up the tubes' slack
GRASP_MAX_SLIP_M = 0.0015  # assumed
SPREAD_MIN_M = 0.004  # assumed: between the tubes' walls at mid-length
TAUT_MIN = 0.975  # assumed: a tube's end-to-end distance over its length at rest

# Retracting the right arm.
RETRACTED_M = 0.015  # distance of the right tip from the tubes

# Injury.
PINCH_MAX_N = 15.0  # grasping sheet: a pinch of 15-37 N damages bowel
TRACTION_MAX_N = 5.0  # grasping sheet: pulls of 5 N
LIVER_MAX_N = 2.0  # assumed: instrument on liver, or tissue on liver beyond the value at rest
INSTRUMENT_CONTACT_MAX_N = 0.5  # assumed: between the two arms
JOINT_MARGIN_RAD = 1.0e-3  # rounding in the simulator's own limits
LEAK_MAX_M3 = 0.0  # any leak is an injury
TORN_MAX = 0  # broken attachments of a tube to the sac, or of the sac to the liver bed

# Ultimate strength.
STRENGTH_PA = {
    "duct": 1.4e6,  # assumed equal to the artery's, the weaker of the two measured walls
    "artery": 1.4e6,  # reference sheet
    "second artery": 1.4e6,
    "common bile duct": 1.4e6,
    "hepatic artery": 1.4e6,
}
SAC_MAX_STRETCH = 2.0  # assumed: of a patch of the gallbladder's wall, see `material`
