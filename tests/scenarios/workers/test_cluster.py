"""Tests of `--cluster`: errors are one line and come soon; work runs as on one machine."""

import socket
import threading
import time
from importlib.util import find_spec

import pytest

from scenarios.cli import main
from tests.scenarios.example_results import read_results
from tests.scenarios.from_the_shell.complaint import complaint

ray_needed = pytest.mark.skipif(find_spec("ray") is None, reason="Ray is not installed")


@pytest.mark.skipif(find_spec("ray") is not None, reason="Ray is installed")
@pytest.mark.parametrize("command", ["run", "collect"])
def test_without_ray_the_error_says_how_to_get_it(command, tmp_path, capfd):
    line = complaint(capfd, command, "--cluster", "127.0.0.1:6379", "--out", str(tmp_path))
    assert "pip install -e '.[cluster]'" in line


@pytest.mark.cluster
@ray_needed
@pytest.mark.parametrize("address", ["here", "127.0.0.1", "127.0.0.1:port", "a b:6379", ":6379"])
def test_an_invalid_address_is_refused(address, tmp_path, capfd):
    line = complaint(capfd, "run", "--cluster", address, "--out", str(tmp_path))
    assert f"{address!r} is not HOST:PORT" in line


@pytest.mark.cluster
@ray_needed
@pytest.mark.parametrize("answer", [None, b"", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_an_address_where_no_ray_answers_is_refused_soon(answer, tmp_path, capfd):
    """Try an address where nobody listens, a silent server, and one that speaks HTTP."""
    server = socket.create_server(("127.0.0.1", 0))
    address = f"127.0.0.1:{server.getsockname()[1]}"
    start_s = time.monotonic()
    if answer is None:
        server.close()
    with server:
        if answer:
            threading.Thread(target=lambda: server.accept()[0].sendall(answer)).start()
        line = complaint(capfd, "run", "--cluster", address, "--out", str(tmp_path / "out"))
    assert f"--cluster {address}: " in line
    assert time.monotonic() - start_s < 15
    assert not (tmp_path / "out").exists()


@pytest.mark.cluster
@pytest.mark.slow
def test_episodes_and_demonstrations_are_made_on_two_nodes(two_nodes, tmp_path, capfd):
    there = ["--episodes", "2", "--workers", "2", "--cluster", two_nodes.address, "--out"]
    assert main(["run", "--seed", "10000", *there, str(tmp_path / "run")]) == 0
    assert [e.seed for e in read_results(tmp_path / "run" / "results.json")] == [10_000, 10_001]
    assert main(["collect", "--seed", "0", *there, str(tmp_path / "demos")]) == 0
    assert "2 episodes" in capfd.readouterr().out.splitlines()[-1]
