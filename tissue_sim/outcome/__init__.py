"""Has a task succeeded? The answer depends on the physical state only."""
