"""Define the control period for all packages."""

CONTROL_PERIOD_S = 1.0 / 30.0  # time between two commands to the arms
CONTROL_HZ = round(1.0 / CONTROL_PERIOD_S)
