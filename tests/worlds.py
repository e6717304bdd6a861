"""Worlds of their own, for tests that share none."""

from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.world import World


def textbook_world(seed: int) -> World:
    """Return a new world with the textbook patient of this seed."""
    world = World()
    world.reset(textbook_from_seed(seed))
    return world
