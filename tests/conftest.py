"""Settings for all tests: no test has a deadline, because benches measure the speed."""

import gc
import os
from functools import partial

import pytest
from hypothesis import HealthCheck, settings

from tests.made_once import MadeOnce, made_once
from tests.stand_ins import stand_in

# As `make test`: with two threads, on a busy machine, a training once did not resume to the bit.
os.environ.setdefault("OMP_NUM_THREADS", "1")
settings.register_profile("laws", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("laws")


@pytest.fixture(scope="session", name="made_once")
def _made_once(tmp_path_factory: pytest.TempPathFactory) -> MadeOnce:
    """Return a function that makes something once for all workers of this test run."""
    root = tmp_path_factory.getbasetemp()
    return partial(made_once, root.parent if "PYTEST_XDIST_WORKER" in os.environ else root)


@pytest.fixture(scope="session", autouse=True)
def _stand_ins(made_once: MadeOnce) -> None:
    """Let untrained networks stand in for policies that are not trained for this world yet."""
    stand_in(made_once)


SLOW_NOTEBOOKS = ("04_train.ipynb", "05_results.ipynb")


@pytest.hookimpl(tryfirst=True)  # before those that are slow are left out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark notebooks that take half a minute as slow."""
    for item in items:
        if item.path.name in SLOW_NOTEBOOKS:
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish() -> None:
    """Exempt what the imports made from garbage collection, which would search it for each test."""
    gc.collect()
    gc.freeze()
