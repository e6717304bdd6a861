"""Define the bounds within which every network normalises its input."""

MIN_DEVIATION = 1e-3  # of a feature or of a chunk's entry: tiny variations are not amplified
MAX_DEVIATIONS = 6.0  # values outside the training's range are clipped here
