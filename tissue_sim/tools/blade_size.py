"""Define the size of the scissors' blades."""

BLADE_LENGTH_M = 0.011  # assumed: curved scissors
