"""The version of the world: checkpoints, states, recordings and datasets keep it."""

WORLD_VERSION = 6  # raise when physics changes
