"""Is the tissue model correct? Closed forms, a converged static solver, and experiments."""
