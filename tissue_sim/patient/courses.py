"""State the geometry of uncommon courses of duct and artery, as ranges of their parameters.

Shapes follow the usual descriptions of surgical anatomy; the numbers are assumed. Seeds draw these
courses at published shares, and scenarios select them by name.
"""

from __future__ import annotations

from collections.abc import Mapping

Bounds = tuple[float, float]

# The artery crosses at the neck: below it, duct and artery spread to their usual sides.
CROSSING_LENGTH_M: Bounds = (0.033, 0.039)
_CROSSING: Mapping[str, Bounds] = {
    "duct_angle_rad": (0.32, 0.45),
    "artery_angle_rad": (0.38, 0.48),
}
IN_FRONT: Mapping[str, Bounds] = {
    **_CROSSING,
    "artery_insertion_m": (0.010, 0.012),
    "artery_turn_rad": (2.35, 2.55),
    "artery_depth_m": (-0.008, -0.006),
}
BEHIND: Mapping[str, Bounds] = {
    **_CROSSING,
    "artery_insertion_m": (0.008, 0.010),
    "artery_turn_rad": (-2.55, -2.35),
    "artery_depth_m": (0.005, 0.007),
}
# The cystic duct is long and runs beside the common hepatic duct before it joins.
LOW_LENGTH_M: Bounds = (0.042, 0.050)
LOW_INSERTION: Mapping[str, Bounds] = {
    "duct_angle_rad": (-0.14, -0.04),
    "artery_angle_rad": (0.45, 0.55),
}
# The second artery, by the fields of `Artery`, is thin, deep, and enters the sac higher.
SECOND_ARTERY: Mapping[str, Bounds] = {
    "length_m": (0.022, 0.030),
    "diameter_m": (0.0009, 0.0012),
    "angle_rad": (0.00, 0.12),
    "slack": (0.05, 0.08),
    "depth_m": (0.003, 0.006),
    "insertion_m": (0.011, 0.012),
    "turn_rad": (-1.1, -0.8),
}
