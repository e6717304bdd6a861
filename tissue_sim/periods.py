"""The control period, owned here for all packages."""

CONTROL_PERIOD_S = 1.0 / 30.0  # from one command to the arms to the next
CONTROL_HZ = round(1.0 / CONTROL_PERIOD_S)
