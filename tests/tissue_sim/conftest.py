"""A world that tests share, because building one costs more than resetting it."""

import pytest

from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.world import World


@pytest.fixture(scope="module")
def one_world() -> World:
    return World()


@pytest.fixture
def world(request: pytest.FixtureRequest, one_world: World) -> World:
    """Return the world, reset for each test to the textbook patient of the module's `SEED`."""
    one_world.reset(textbook_from_seed(request.module.SEED))
    return one_world
