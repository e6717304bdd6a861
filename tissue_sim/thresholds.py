"""Every number that decides success or injury, in one place, with its source."""

from __future__ import annotations

import numpy as np

# Clips: Hem-o-lok instructions for use as summarised in the reference sheet.
CLIP_MAX_TILT_RAD = np.deg2rad(30.0)
CLIP_MIN_GAP_M = 0.0015  # between neighbouring clips
CUFF_MIN_M = 0.001  # tissue between a clip and the cut, or a clip and a tube's end
LUMEN_CLOSED = 0.10  # lumen's area over its area at rest
CLIP_MAX_SLIP_M = 0.0005  # under a pull, assumed
TEST_PULL_N = 1.0  # every clip holds this at the end

# Grasp.
GRASP_HOLD_S = 1.0
GRASP_MAX_JAW_RAD = 0.6  # assumed: wider open, tissue is wedged between the jaws, not grasped
HELD_PINCH_N = 0.5  # below it the grasper touches and does not hold, assumed
GRASP_MIN_TRACTION_N = 0.15  # assumed: lifts the tubes off slack
GRASP_MAX_SLIP_M = 0.0015  # assumed
SPREAD_MIN_M = 0.004  # between the tubes' walls at mid-length, assumed
TAUT_MIN = 0.975  # straight distance over length at rest of a tube, assumed

# Going back.
RETRACTED_M = 0.015  # right tip to the tubes

# Injury.
PINCH_MAX_N = 15.0  # grasping sheet: damage of bowel at a 15-37 N pinch
TRACTION_MAX_N = 5.0  # grasping sheet: pulls of 5 N
LIVER_MAX_N = 2.0  # against the liver: instrument, or tissue beyond its own rest, assumed
INSTRUMENT_CONTACT_MAX_N = 0.5  # arm against arm, assumed
JOINT_MARGIN_RAD = 1.0e-3  # rounding of the simulator's own limits
LEAK_MAX_M3 = 0.0  # any leak is an injury
TORN_MAX = 0  # attachments of a tube in the sac, or of the sac on the liver bed

# Ultimate strength.
STRENGTH_PA = {
    "duct": 1.4e6,  # assumed: as the artery's, the weaker of the two walls that were measured
    "artery": 1.4e6,  # reference sheet
    "second artery": 1.4e6,
}
SAC_MAX_STRETCH = 2.0  # of a patch of the gallbladder's wall, assumed: see `material`
