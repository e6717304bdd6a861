"""Which body lies on the table? Anatomy from a seed, and the mesh and walls made from it."""
