"""Which body is on the table? The anatomy comes from a seed, mesh and walls from the anatomy."""
