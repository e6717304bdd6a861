"""Tests of paths and folders that cannot be used: one line, exit code 2, before any episode."""

import fcntl
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from scenarios.commands.folder_options import LOCK, claimed
from scenarios.files.errors import BadInputError
from tests.scenarios.from_the_shell.complaint import complaint
from tests.slow import slow
from tissue_sim.rendering.renderer import renderer_available

ENVIRONMENT = os.environ | {"PYTHONPATH": str(Path(__file__).parents[3])}
LONG = "x" * 300
NOT_UTF8 = os.fsdecode(b"\xff-folder")
WRITERS = [
    ["run", "--out"],
    ["evaluate", "--out"],
    ["collect", "--out"],
    ["train", "planner", "--out"],
    ["view", "--out"],
]
READERS = [
    ["replay"],
    ["replay", "--verify"],
    ["run", "--instruct"],
    ["run", "--controller", "diffusion", "--checkpoint"],
    ["run", "--planner", "learned", "--planner-checkpoint"],
    ["train", "planner", "--data"],
    ["train", "controller", "--base"],
]
FILE_WRITERS = [["run", "--video"]]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    yield
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("words", [*WRITERS, *READERS, *FILE_WRITERS], ids=" ".join)
def test_a_path_that_is_not_utf8_is_refused(capfd, words):
    assert "b'\\xff-folder' is not UTF-8" in complaint(capfd, *words, NOT_UTF8)


@pytest.mark.parametrize("words", [*WRITERS, *READERS], ids=" ".join)
def test_a_name_of_300_characters_is_refused(capfd, words):
    line = complaint(capfd, *words, LONG)
    assert any(said in line.lower() for said in ("too long", "no such file", "there is no"))


@pytest.mark.parametrize("words", FILE_WRITERS, ids=" ".join)
def test_a_name_that_leaves_no_room_for_its_partial_file_is_refused(capfd, words):
    if not renderer_available():
        pytest.skip("SAPIEN finds no Vulkan renderer here")
    assert "a name of 255 bytes is too long" in complaint(capfd, *words, "x" * 251 + ".mp4")


@pytest.mark.parametrize("words", WRITERS, ids=" ".join)
def test_a_path_that_leaves_no_room_below_it_is_refused(capfd, tmp_path, words):
    deep = str(tmp_path / Path(*["y" * 200] * 20))[: 4096 - 100]
    assert "--out: the path is longer than" in complaint(capfd, *words, deep)


def test_a_current_folder_that_was_removed_is_one_line(capfd, tmp_path):
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    try:
        assert "the current folder was removed" in complaint(capfd, "run")
    finally:
        os.chdir(tmp_path)


@pytest.mark.parametrize("words", WRITERS, ids=" ".join)
def test_a_folder_that_another_process_writes_to_is_refused_and_its_process_named(
    capfd, tmp_path_factory, words
):
    shared = tmp_path_factory.mktemp("shared")
    with claimed(shared, "--out"):
        line = complaint(capfd, *words, str(shared))
    assert f"--out: process {os.getpid()} is writing to {shared}" in line
    assert list(shared.iterdir()) == []


HOLD_AND_DIE = """
import os, signal, sys
from pathlib import Path
from scenarios.commands.folder_options import claimed
with claimed(Path(sys.argv[1]), "--out"):
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_lock_of_a_killed_process_does_not_block_and_is_removed(tmp_path_factory):
    shared = tmp_path_factory.mktemp("shared")
    died = subprocess.run(
        [sys.executable, "-c", HOLD_AND_DIE, str(shared)], env=ENVIRONMENT, check=False
    )
    assert died.returncode == -signal.SIGKILL
    assert (shared / LOCK).exists()
    with claimed(shared, "--out"):
        assert (shared / LOCK).read_text() == str(os.getpid())
    assert list(shared.iterdir()) == []


def test_a_lock_file_that_was_removed_is_no_lock(tmp_path_factory):
    """Check that who waits for a lock does not get one on a file that nobody else can see."""
    shared = tmp_path_factory.mktemp("shared")
    with (shared / LOCK).open("a+") as removed:
        fcntl.flock(removed, fcntl.LOCK_EX)
        (shared / LOCK).unlink()
        with (
            claimed(shared, "--out"),
            pytest.raises(BadInputError, match=str(os.getpid())),
            claimed(shared, "--out"),
        ):
            pass


def test_a_claim_of_a_new_folder_leaves_none_behind_and_one_that_is_used_stays(tmp_path_factory):
    root = tmp_path_factory.mktemp("root")
    with claimed(root / "new" / "below", "--out"):
        pass
    assert list(root.iterdir()) == []
    with claimed(root / "new", "--out"):
        (root / "new" / "file").touch()
    assert [path.name for path in (root / "new").iterdir()] == ["file"]


@pytest.mark.parametrize("variable", ["XDG_CACHE_HOME", slow("WARP_CACHE_PATH")])
@pytest.mark.parametrize(
    "command", ["run", *map(slow, ["evaluate", "collect --out x", "view", "bench world"])]
)
def test_a_cache_that_cannot_be_written_to_is_found_before_the_first_episode(
    tmp_path_factory, tmp_path, variable, command
):
    """Check it in a process of its own: this one has its kernels already."""
    file = tmp_path_factory.mktemp("home") / "file"
    file.touch()
    ended = subprocess.run(
        [sys.executable, "-m", "scenarios.cli", *command.split()],
        env=ENVIRONMENT | {variable: str(file)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    (line,) = [line for line in ended.stderr.splitlines() if not line.startswith("Warp")]
    assert line.startswith(f"calot: {variable}: cannot write to {file}")


def test_a_new_cache_on_a_full_disk_is_found_before_the_first_episode(tmp_path_factory, tmp_path):
    home = tmp_path_factory.mktemp("home")
    ended = subprocess.run(
        [sys.executable, "-B", "-m", "scenarios.cli", "run"],
        env=ENVIRONMENT | {"HOME": str(home)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (2_000, 2_000)),
    )
    assert ended.returncode == 2, ended.stderr
    (line,) = [line for line in ended.stderr.splitlines() if not line.startswith("Warp")]
    assert line.startswith(f"calot: XDG_CACHE_HOME: cannot write to {home / '.cache/calot'} (File")


def test_a_cache_that_is_full_but_holds_all_kernels_is_enough(full_disk):
    from scenarios.commands.folder_options import require_kernel_cache

    require_kernel_cache()
