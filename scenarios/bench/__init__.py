"""How fast and how accurate each part is on this machine: one file a bench."""
