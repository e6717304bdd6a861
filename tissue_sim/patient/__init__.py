"""Which body lies on the table: its anatomy from a seed, and the mesh and walls made of it."""
