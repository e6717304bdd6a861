"""Tests of the private renderer: where it comes from and when it is used; without network."""

import os
import subprocess
import sys
from venv import EnvBuilder

import pytest

from tissue_sim.rendering import renderer_fetch
from tissue_sim.rendering.renderer import (
    DRIVER,
    DRIVERS_VARIABLE,
    LIBRARIES,
    OTHER_CHOICES,
    use_private_renderer,
)
from tissue_sim.rendering.renderer_fetch import FetchError, backports, fetch

LINES = """# the machine's own
deb [signed-by=/keys/a.gpg] http://mirror.invalid/debian bookworm main contrib
deb http://mirror.invalid/debian bookworm-updates main
deb-src http://mirror.invalid/debian bookworm main
"""
STANZAS = """Types: deb
URIs: http://mirror.invalid/debian
Suites: bookworm bookworm-updates
Components: main
Signed-By: /keys/a.gpg

Types: deb
URIs: http://mirror.invalid/security
Suites: bookworm-security
Components: main
"""


@pytest.fixture(name="no_choice")
def _no_choice(monkeypatch: pytest.MonkeyPatch) -> pytest.MonkeyPatch:
    """Take away every choice of a driver, and put it back after the test."""
    for variable in (DRIVERS_VARIABLE, *OTHER_CHOICES):
        monkeypatch.setenv(variable, "")  # so that it is put back
        monkeypatch.delenv(variable)
    return monkeypatch


@pytest.fixture(name="fetched")
def _fetched(tmp_path):
    """Return a folder as the fetching leaves it, whose driver needs no library."""
    folder = tmp_path / "fetched"
    folder.mkdir()
    (folder / DRIVER).write_text("{}")
    (folder / LIBRARIES).write_text("")
    return folder


def test_backports_are_at_the_address_of_the_releases_own_line():
    assert backports(LINES, "bookworm") == (
        "deb [signed-by=/keys/a.gpg] http://mirror.invalid/debian bookworm-backports main contrib"
    )


def test_backports_are_at_the_address_of_the_releases_own_stanza():
    assert backports(STANZAS, "bookworm") == STANZAS.split("\n\n")[0].replace(
        "bookworm bookworm-updates", "bookworm-backports"
    )


@pytest.mark.parametrize("sources", [LINES, STANZAS])
def test_sources_of_another_release_have_no_backports_here(sources):
    assert backports(sources, "trixie") == ""
    assert backports(backports(sources, "bookworm"), "bookworm") == ""


def test_a_machine_without_apt_is_told_so_and_left_alone(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", "")
    with pytest.raises(FetchError, match="apt-get is not here"):
        fetch(tmp_path / "renderer")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(name="programs")
def _programs(tmp_path_factory, monkeypatch):
    """Have apt-get, dpkg and ldd fail, each with two lines."""
    folder = tmp_path_factory.mktemp("programs")
    for name in renderer_fetch.PROGRAMS:
        (folder / name).write_text(f"#!/bin/sh\necho {name}: broken >&2\necho more >&2\nexit 2\n")
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(folder))


@pytest.mark.usefixtures("programs")
def test_a_package_that_cannot_be_unpacked_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr(renderer_fetch, "_downloaded", lambda root: [root / "mesa.deb"])
    with pytest.raises(FetchError, match=r"^mesa\.deb cannot be unpacked: dpkg: broken$"):
        fetch(tmp_path / "renderer")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("programs")
def test_a_folder_that_cannot_be_written_to_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(FetchError, match=r"file: File exists$"):
        fetch(tmp_path / "file" / "renderer")


@pytest.mark.usefixtures("no_choice")
def test_what_was_fetched_is_used_by_this_process_and_those_it_starts(fetched):
    assert use_private_renderer(fetched)
    assert os.environ[DRIVERS_VARIABLE] == str(fetched / DRIVER)
    assert use_private_renderer(fetched)


@pytest.mark.usefixtures("no_choice")
def test_where_nothing_was_fetched_nothing_changes(tmp_path):
    assert not use_private_renderer(tmp_path)
    assert DRIVERS_VARIABLE not in os.environ


@pytest.fixture(name="another_python")
def _another_python(tmp_path, fetched):
    """Return a Python whose environment has the fetched renderer, and this one's packages."""
    EnvBuilder(symlinks=True).create(tmp_path / "environment")
    fetched.rename(tmp_path / "environment" / "renderer")
    return tmp_path / "environment" / "bin" / "python"


@pytest.mark.usefixtures("no_choice")
@pytest.mark.parametrize("library", ["missing.so", "broken.so"])
def test_a_broken_renderer_is_none(library, another_python):
    folder = another_python.parents[1] / "renderer"
    (folder / "broken.so").write_text("not a library")
    (folder / LIBRARIES).write_text(library)
    asked = (
        "from tissue_sim.rendering import renderer;"
        "assert not renderer.renderer_available();"
        "renderer.render_system()"
    )
    told = subprocess.run(
        [another_python, "-c", asked],
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    last = told.stderr.splitlines()[-1]
    assert last.startswith("RuntimeError: renderer: the private one is broken: ")
    assert library in last


@pytest.mark.parametrize("variable", [DRIVERS_VARIABLE, *OTHER_CHOICES])
def test_a_driver_that_the_user_chose_stays_chosen(variable, fetched, no_choice):
    no_choice.setenv(variable, "another.json")
    before = dict(os.environ)
    assert not use_private_renderer(fetched)
    assert dict(os.environ) == before
