"""Tests of `calot replay` and `calot view`: an impossible request is refused in one line."""

import shutil
import socket
from itertools import islice

import pytest

from scenarios.catalogue import ORACLE
from scenarios.cli import main
from scenarios.commands.replay import VIEW_EVERY
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.recorder import Recorder
from scenarios.run_episode import begin
from scenarios.viewer.recording_frames import RecordingFrames
from tests.scenarios.from_the_shell.complaint import complaint
from tests.scenarios.recording.tampering import tampered


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    config = EpisodeConfig(**ORACLE, scenario="textbook", seed=10_008)
    episode, path = begin(config), tmp_path_factory.mktemp("replay") / "10008.npz"
    with Recorder(config=config, path=path) as recorder:
        recorder.on_reset(episode.world)
        for step in islice(episode.steps(), 60):
            recorder.on_step(step)
    return path


def changed(recording, path):
    def edit(header, arrays):
        arrays["joints"][30:, 0, 0] += 1e-12

    tampered(recording, path, edit)


def test_a_recording_that_repeats_is_reported_as_identical(recording, capfd):
    assert main(["replay", str(recording)]) == 0
    assert "identical to the bit: time, joints" in capfd.readouterr().out


def test_a_recording_that_does_not_repeat_is_reported(recording, tmp_path, capfd):
    changed(recording, tmp_path / "changed.npz")
    assert main(["replay", str(tmp_path / "changed.npz")]) == 1
    assert "different from 1.0 s on" in capfd.readouterr().out


@pytest.fixture
def ctrl_c_after(monkeypatch):
    """Return a function that has Ctrl-C come after some frames of each replay."""
    whole = RecordingFrames.run

    def interrupt(n_frames):
        def run(self):
            yield from islice(whole(self), n_frames)
            raise KeyboardInterrupt

        monkeypatch.setattr(RecordingFrames, "run", run)

    return interrupt


def test_a_view_that_is_left_early_says_how_far_the_replay_is_identical(
    recording, ctrl_c_after, capfd
):
    ctrl_c_after(1 + 30 // VIEW_EVERY)
    assert main(["replay", str(recording), "--view", "--beside", str(recording)]) == 130
    first, second = capfd.readouterr().out.splitlines()
    assert first == f"{recording}: interrupted at 1.0 s of 2.0 s, identical so far"
    assert second == f"{recording}: interrupted at 0.0 s of 2.0 s, identical so far"


def test_a_view_that_is_left_when_all_was_replayed_is_identical(recording, ctrl_c_after, capfd):
    ctrl_c_after(1 + 60 // VIEW_EVERY)
    assert main(["replay", str(recording), "--view"]) == 0
    assert "injuries of 60 steps; not compared" in capfd.readouterr().out


def test_a_view_that_is_left_after_a_difference_is_different(
    recording, tmp_path, ctrl_c_after, capfd
):
    changed(recording, tmp_path / "changed.npz")
    ctrl_c_after(1 + 45 // VIEW_EVERY)
    files = [str(tmp_path / "changed.npz"), "--view", "--beside", str(recording)]
    assert main(["replay", *files]) == 1
    assert "different from 1.0 s on" in capfd.readouterr().out


@pytest.mark.slow
def test_verifying_several_tells_which_differs_where_and_which_cannot_be_run(
    recording, tmp_path, capfd
):
    shutil.copy(recording, tmp_path / "same.npz")
    assert main(["replay", "--verify", str(tmp_path / "same.npz")]) == 0
    assert "identical, 60 steps" in capfd.readouterr().out
    changed(recording, tmp_path / "below" / "changed.npz")
    assert main(["replay", "--verify", str(tmp_path)]) == 1
    assert main(["replay", "--verify", str(tmp_path / "below" / "changed.npz")]) == 1
    out = capfd.readouterr().out
    assert "1 of 2 identical" in out
    assert "differs, from step 30 on: joints by 1e-12" in out
    (tmp_path / "cut.npz").write_bytes(recording.read_bytes()[:1000])
    assert main(["replay", "--verify", "--workers", "2", str(tmp_path)]) == 2
    assert "1 of 3 identical" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["replay"], "give one FILE, got 0"),
        (["replay", "a.npz", "b.npz"], "--verify takes several"),
        (["replay", "--verify"], "--verify needs a FILE or a folder"),
        (["replay", "--verify", "."], "no recordings"),
        (["replay", "--verify", "none.npz"], "none.npz: No such file"),
        (["replay", "--verify", "--view", "none.npz"], "--view"),
        (["replay", "--verify", "text.npz"], "no recording"),
    ],
)
def test_an_impossible_verification_is_refused_in_one_line(
    words, said, tmp_path, monkeypatch, capfd
):
    monkeypatch.chdir(tmp_path)
    if words[-1] == "text.npz":
        (tmp_path / "text.npz").write_text("hello")
    assert said in complaint(capfd, *words)


def test_an_exported_page_holds_all_it_needs(recording, tmp_path, capfd):
    page = tmp_path / "page.html"
    assert main(["replay", str(recording), "--export", str(page)]) == 0
    content = page.read_text()
    assert "__VISER_EMBED_DATA__" in content
    assert 'src="http' not in content


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--export", "."], "--export: . is a folder; name a file"),
        (["--export", "page.html", "--view"], "--view cannot be combined with --export"),
    ],
)
def test_a_page_that_cannot_be_exported_is_refused_before_it_is_drawn(
    recording, tmp_path, monkeypatch, capfd, words, said
):
    monkeypatch.chdir(tmp_path)
    assert said in complaint(capfd, "replay", str(recording), *words)
    assert list(tmp_path.iterdir()) == []


def test_a_page_that_finds_no_room_is_one_line(recording, tmp_path, capfd, request):
    page = tmp_path / "page.html"
    request.getfixturevalue("full_disk")
    assert main(["replay", str(recording), "--export", str(page)]) == 2
    line = capfd.readouterr().err.splitlines()[-1]
    assert line == f"calot: --export: cannot write {page} (File too large)"
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_recording_is_refused(tmp_path, capfd):
    assert "No such file" in complaint(capfd, "replay", str(tmp_path / "none.npz"))
    (tmp_path / "text.npz").write_text("hello")
    assert "no recording" in complaint(capfd, "replay", str(tmp_path / "text.npz"))


def test_a_second_recording_needs_a_page_to_be_seen_on(recording, capfd):
    assert "--view" in complaint(capfd, "replay", str(recording), "--beside", str(recording))


def test_a_busy_port_that_was_asked_for_is_refused(tmp_path, capfd):
    with socket.create_server(("127.0.0.1", 0)) as busy:
        port = busy.getsockname()[1]
        told = complaint(capfd, "view", "--port", str(port), "--out", str(tmp_path))
    assert f"--port {port}" in told
    assert "in use" in told


def test_an_invalid_address_is_refused(tmp_path, capfd):
    words = ("view", "--host", "203.0.113.7", "--out", str(tmp_path))
    assert "--host 203.0.113.7" in complaint(capfd, *words)


def test_one_page_needs_one_worker(tmp_path, capfd):
    words = ("run", "--view", "--workers", "2", "--out", str(tmp_path))
    assert "--workers 1" in complaint(capfd, *words)
