"""Whether a task has succeeded, read from the physical state only."""
