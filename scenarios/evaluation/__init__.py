"""Run systems on the same anatomies, compare them, and report."""
