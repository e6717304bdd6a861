"""What all tests of the page share: ports of their own."""

import os

import pytest

from scenarios.viewer.serving import port


@pytest.fixture(autouse=True)
def _ports_of_this_process(monkeypatch):
    """Let tests that run at the same time look for a free port in different places."""
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    monkeypatch.setattr(port, "FIRST_PORT", 20_000 + port.PORTS * worker)
