"""What several tests need: a whole real procedure, run once, a cluster, ports, a full disk."""

import os
import resource
import sys

import pytest

from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.viewer.serving import port
from tests.scenarios.procedures import Procedure, run_by_command, run_once


@pytest.fixture(scope="session")
def procedure(made_once) -> Procedure:
    return run_once(
        EpisodeConfig(**ORACLE, scenario="textbook", seed=10_004), "procedure", made_once
    )


@pytest.fixture(scope="session")
def ran_by_command(made_once):
    """Return folder and output of a whole procedure that `calot run` ran in its own process."""
    return made_once("ran_by_command", run_by_command)


@pytest.fixture(scope="session")
def two_nodes():
    """Yield a Ray cluster of two nodes with one core each, both on this machine."""
    ray = pytest.importorskip("ray", reason="Ray is not installed")
    from ray.cluster_utils import Cluster

    cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
    cluster.add_node(num_cpus=1)
    cluster.wait_for_nodes()
    yield cluster
    ray.shutdown()
    cluster.shutdown()


@pytest.fixture(autouse=True)
def _ports_of_this_process(monkeypatch):
    """Let tests that run at the same time look for a free port in different places."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    monkeypatch.setattr(port, "FIRST_PORT", 20_000 + port.PORTS * worker)


@pytest.fixture
def full_disk(monkeypatch):
    """Allow no file to grow beyond 2 kB while a test uses this fixture.

    Python takes a compiled module that was cut short for whole, so none is written meanwhile.
    """
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")  # of worker processes
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, hard))
    yield
    resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
