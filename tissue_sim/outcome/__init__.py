"""Has a task succeeded? Read from the physical state only."""
