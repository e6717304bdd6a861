"""How do results get to disk and to people? As strict JSON with versions, and as plain text."""
