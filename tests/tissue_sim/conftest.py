"""A world that tests share, because building one costs more than resetting it."""

import pytest

from tissue_sim.world import World


@pytest.fixture(scope="module")
def one_world() -> World:
    return World()
