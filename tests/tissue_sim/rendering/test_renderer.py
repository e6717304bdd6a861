"""Tests of the private renderer: where it comes from and when it is used; without network."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from venv import EnvBuilder

import pytest

from tissue_sim.rendering import renderer
from tissue_sim.rendering.renderer import (
    DRIVER,
    DRIVERS_VARIABLE,
    LIBRARIES,
    OTHER_CHOICES,
    use_private_renderer,
)

BASH = shutil.which("bash") or "bash"
SCRIPT = Path(renderer.__file__).with_name("fetch_renderer.sh")
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


def shell(command, *arguments):
    """Run a command with the functions of the script that fetches."""
    program = f'source "{SCRIPT}"; {command}'
    return subprocess.run(
        [BASH, "-c", program, "bash", *map(str, arguments)], capture_output=True, text=True
    )


def complaint(command, *arguments):
    """Return what a command that fails tells: one line."""
    told = shell(command, *arguments)
    assert told.returncode != 0
    assert told.stdout == ""
    (line,) = told.stderr.splitlines()
    return line


@pytest.fixture(name="backports")
def _backports(tmp_path):
    """Return a function from package sources and a release to the sources of its backports."""

    def backports(sources, release):
        file = tmp_path / ("own.sources" if "Types:" in sources else "own.list")
        file.write_text(sources)
        return shell('backports "$1" "$2"', release, file).stdout.strip()

    return backports


def test_backports_are_at_the_address_of_the_releases_own_line(backports):
    assert backports(LINES, "bookworm") == (
        "deb [signed-by=/keys/a.gpg] http://mirror.invalid/debian bookworm-backports main contrib"
    )


def test_backports_are_at_the_address_of_the_releases_own_stanza(backports):
    assert backports(STANZAS, "bookworm") == STANZAS.split("\n\n")[0].replace(
        "bookworm bookworm-updates", "bookworm-backports"
    )


@pytest.mark.parametrize("sources", [LINES, STANZAS, STANZAS.replace("deb\n", "deb-src\n")])
def test_sources_of_another_release_or_of_no_packages_have_no_backports_here(backports, sources):
    assert backports(sources, "trixie") == ""
    assert backports(backports(sources, "bookworm"), "bookworm") == ""
    assert ("deb-src\n" in sources) <= (backports(sources, "bookworm") == "")


def test_a_machine_without_apt_is_told_so_and_left_alone(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", "")
    assert complaint('fetch "$1"', tmp_path / "renderer").endswith("apt-get is not here.")
    assert list(tmp_path.iterdir()) == []


@pytest.fixture(name="programs")
def _programs(tmp_path_factory, monkeypatch):
    """Have apt-get, dpkg and ldd fail, each with two lines."""
    folder = tmp_path_factory.mktemp("programs")
    for name in ("apt-get", "dpkg", "ldd"):
        (folder / name).write_text(f"#!/bin/sh\necho {name}: broken >&2\necho more >&2\nexit 2\n")
        (folder / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")


@pytest.mark.usefixtures("programs")
def test_a_package_that_cannot_be_unpacked_is_one_line(tmp_path):
    made = 'download() { mkdir -p "$1/cache/archives"; touch "$1/cache/archives/mesa.deb"; }'
    told = complaint(f'{made}; fetch "$1"', tmp_path / "renderer")
    assert told == "No renderer: mesa.deb cannot be unpacked: dpkg: broken."
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("programs")
def test_a_folder_that_cannot_be_written_to_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    assert complaint('fetch "$1"', tmp_path / "file" / "renderer").endswith("File exists.")


@pytest.mark.usefixtures("no_choice")
@pytest.mark.parametrize("variable", [DRIVERS_VARIABLE, *OTHER_CHOICES])
def test_no_renderer_is_fetched_beside_a_chosen_driver_that_does_not_work(
    variable, another_python, no_choice
):
    shutil.rmtree(another_python.parents[1] / "renderer")
    no_choice.setenv(variable, "another.json")
    told = complaint('main "$1"', another_python)
    assert told == f"No renderer: {variable} names a driver that does not work."
    assert not (another_python.parents[1] / "renderer").exists()


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
