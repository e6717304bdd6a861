"""One whole real procedure, run once for every test that looks at it."""

import pytest

from scenarios.episode_config import EpisodeConfig
from tests.scenarios.procedures import Procedure, run


@pytest.fixture(scope="session")
def procedure(tmp_path_factory) -> Procedure:
    return run(EpisodeConfig(seed=10_004), tmp_path_factory.mktemp("procedure"))
