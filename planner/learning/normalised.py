"""Within which bounds every network normalises what it is told."""

MIN_DEVIATION = 1e-3  # of a feature or of a chunk's entry: what hardly varies is not blown up
MAX_DEVIATIONS = 6.0  # what lies further out than anything seen is taken to lie here
