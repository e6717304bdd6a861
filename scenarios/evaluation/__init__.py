"""Arms compared on the same anatomies: run, counted, told."""
