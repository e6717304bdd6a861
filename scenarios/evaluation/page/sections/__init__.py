"""Which sections has a report? One a file."""
