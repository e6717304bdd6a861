"""Demonstrations by the expert: nominal, recovering from failures set up on purpose, corrected."""
