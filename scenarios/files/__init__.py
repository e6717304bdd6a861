"""How do results get to disk? As strict JSON, with versions."""
