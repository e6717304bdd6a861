"""Define the world's version and its period of control, for all packages.

Checkpoints, states, recordings and datasets store the version.
"""

WORLD_VERSION = 7  # increase this when physics changes

CONTROL_PERIOD_S = 1.0 / 30.0  # time between two commands to the arms
CONTROL_HZ = round(1.0 / CONTROL_PERIOD_S)
