"""Run arms on the same anatomies, compare them, and report."""
