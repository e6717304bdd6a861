"""How do results get to disk? Atomically, as strict JSON, with versions."""
