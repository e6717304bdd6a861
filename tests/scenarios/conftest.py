"""What several tests need: one whole real procedure, run once, and a disk that is full."""

import resource

import pytest

from scenarios.episode_config import EpisodeConfig
from tests.scenarios.procedures import Procedure, run


@pytest.fixture(scope="session")
def procedure(tmp_path_factory) -> Procedure:
    return run(EpisodeConfig(seed=10_004), tmp_path_factory.mktemp("procedure"))


@pytest.fixture
def full_disk():
    """No file may grow beyond 2 kB, from when it is asked for."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
