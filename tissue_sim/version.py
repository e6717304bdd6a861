"""Define the version of the world, which checkpoints, states, recordings and datasets store."""

WORLD_VERSION = 6  # increase this when physics changes
