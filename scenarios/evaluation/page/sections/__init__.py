"""Which sections does a report have? Each file is one section."""
