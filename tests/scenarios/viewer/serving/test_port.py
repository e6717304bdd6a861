"""Tests of the port: a busy one is skipped, or refused if it was requested."""

import json
import re
import socket
import urllib.request

import pytest

from scenarios.commands.browser import page_of
from scenarios.files.errors import BadInputError
from scenarios.viewer.serving import port as ports
from scenarios.viewer.serving.port import PORTS, choose_port
from tests.scenarios.viewer.sessions import running_session

HOST = "127.0.0.1"


@pytest.fixture
def taken():
    with socket.create_server((HOST, 0)) as busy:
        yield busy.getsockname()[1]


def test_a_free_requested_port_is_chosen():
    with socket.create_server((HOST, 0)) as briefly:
        free = briefly.getsockname()[1]
    assert choose_port(HOST, free) == free


def test_a_busy_requested_port_is_refused(taken):
    with pytest.raises(BadInputError, match=f"--port {taken}: .*in use; leave out --port"):
        choose_port(HOST, taken)


def test_a_busy_port_that_was_not_requested_is_skipped():
    free = choose_port(HOST)
    with socket.create_server((HOST, free)):
        following = choose_port(HOST)
    assert free < following < ports.FIRST_PORT + PORTS


def test_the_microphones_port_is_refused_if_it_was_requested_and_else_skipped():
    free = choose_port(HOST)
    assert choose_port(HOST, say_port=free) > free
    with pytest.raises(BadInputError, match=f"--port {free}: --say-port is the same"):
        choose_port(HOST, free, say_port=free)


@pytest.mark.slow
def test_an_address_of_ipv6_is_served_and_printed_in_brackets(tmp_path, capfd):
    """Check the page, what it prints, and `POST /say`."""
    say_port = choose_port("::1")
    with running_session(tmp_path) as session, page_of(session, "::1", None, say_port):
        (opened, spoken) = re.findall(r"http://\S+", capfd.readouterr().err)
        assert urllib.request.urlopen(opened).status == 200
        assert spoken == f"http://[::1]:{say_port}"
        asked = urllib.request.Request(f"{spoken}/say", data=b"stop")
        assert json.load(urllib.request.urlopen(asked))["command"] == "stop"
    assert opened.startswith("http://[::1]:")


@pytest.mark.parametrize("port", [65_536, 1_000_000])
def test_a_number_that_is_no_port_is_refused(port):
    with pytest.raises(BadInputError, match=f"--port {port}"):
        choose_port(HOST, port)


@pytest.mark.parametrize("host", ["203.0.113.7", "no such host", "x" * 300, "[::1]", "a..b"])
def test_an_address_of_another_machine_is_refused(host):
    with pytest.raises(BadInputError, match=re.escape(f"--host {host}")):
        choose_port(host)
