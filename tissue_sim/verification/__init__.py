"""What the tissue is held to: closed forms, a converged static solver, and the experiments."""
