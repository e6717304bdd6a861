"""Tests of atomic writing: a file is complete or does not exist."""

import os

import pytest

from planner.learning.files import write_atomic


def test_the_folder_is_made_and_nothing_else_is_left(tmp_path):
    path = tmp_path / "deep" / "file.txt"
    write_atomic(path, b"whole")
    write_atomic(path, b"replaced")
    assert path.read_bytes() == b"replaced"
    assert list(path.parent.iterdir()) == [path]


def test_a_failed_write_leaves_what_was_there(tmp_path, full_disk):
    path = tmp_path / "file.txt"
    write_atomic(path, b"whole")
    with pytest.raises(OSError, match="File too large"):
        write_atomic(path, b"too much" * 1000)
    assert path.read_bytes() == b"whole"
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_that_is_moved_away_while_a_file_is_written_is_made_again(tmp_path, monkeypatch):
    path, sync = tmp_path / "out" / "file.txt", os.fsync

    def move_away(descriptor):
        monkeypatch.setattr(os, "fsync", sync)
        sync(descriptor)
        path.parent.rename(tmp_path / "gone")

    monkeypatch.setattr(os, "fsync", move_away)
    write_atomic(path, b"whole")
    assert path.read_bytes() == b"whole"
