"""How episodes run side by side, on one machine or on a cluster."""
