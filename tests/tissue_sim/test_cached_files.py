"""Tests of cached files: once for each content, mended where damaged, and none in temporary."""

import os
import subprocess
import sys

import pytest

from tissue_sim.cached_files import cached_folder

FILES = {"a.txt": b"one", "below/b.bin": b"\0two"}


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "calot"


def test_equal_files_share_a_folder_and_others_do_not(cache):
    folder = cached_folder("some", FILES)
    assert {path: (folder / path).read_bytes() for path in FILES} == FILES
    written_ns = (folder / "a.txt").stat().st_mtime_ns
    assert cached_folder("some", FILES) == folder
    assert (folder / "a.txt").stat().st_mtime_ns == written_ns
    assert cached_folder("some", FILES | {"a.txt": b"1"}) != folder
    assert len(list(cache.iterdir())) == 2


def test_a_damaged_or_missing_file_is_written_again():
    folder = cached_folder("some", FILES)
    (folder / "a.txt").write_bytes(b"")
    (folder / "below/b.bin").unlink()
    cached_folder("some", FILES)
    assert {path: (folder / path).read_bytes() for path in FILES} == FILES


MAKE_AND_DIE = """
import os, signal
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.urdf import urdf_path
for visuals in (False, True):
    urdf_path(INSTRUMENTS["grasper"], visuals=visuals)
from tissue_sim.rendering.shader_pack import shader_pack
shader_pack()
os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_killed_process_leaves_nothing_in_the_temporary_folder(cache, tmp_path):
    (tmp_path / "temporary").mkdir()
    environment = os.environ | {"TMPDIR": str(tmp_path / "temporary")}
    for _ in range(2):
        subprocess.run([sys.executable, "-c", MAKE_AND_DIE], env=environment, check=False)
    assert list((tmp_path / "temporary").iterdir()) == []
    assert len(list(cache.iterdir())) == 3  # with and without meshes, and the shaders
