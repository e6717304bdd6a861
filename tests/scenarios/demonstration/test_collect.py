"""Tests of `calot collect`: it resumes where it stopped, keeps failures apart, loses nothing."""

from dataclasses import replace
from hashlib import sha256

import pytest

from controller.dataset.part import part_bytes
from controller.dataset.reader import read_episodes
from controller.diffusion.policy import CHECKPOINTS
from scenarios.cli import main
from scenarios.demonstration import demonstrate as of_demonstrations
from scenarios.demonstration.demonstrate import (
    ERRORS,
    FAILED,
    PARTS,
    checkpoints_of,
    demonstrate,
    is_finished,
    part_path,
)
from scenarios.demonstration.mix import PlannedDemonstration, demonstrations
from tests.controller.dataset.episodes import random_episode
from tests.controller.dataset.test_round_trip import contents

ASKED = demonstrations("nominal", 0, 3)


@pytest.fixture
def out(tmp_path):
    """Return a folder with all demonstrations in ASKED done, the second without success."""
    for demonstration, folder in zip(ASKED, (PARTS, FAILED, PARTS), strict=True):
        path = part_path(demonstration, tmp_path, folder)
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(part_bytes(random_episode(demonstration.seed)))
    return tmp_path


def collect(out, episodes=3, **options):
    words = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    return main(
        ["collect", "--out", str(out), "--mix", "nominal", "--episodes", str(episodes), *words]
    )


def test_finished_parts_are_not_done_again_and_failed_ones_stay_out(out, capfd):
    assert all(is_finished(demonstration, out) for demonstration in ASKED)
    assert collect(out) == 0
    assert "3 existed already" in capfd.readouterr().out
    finished = [episode.header.seed for episode in read_episodes(out)]
    assert finished == [ASKED[0].seed, ASKED[2].seed]


SHIPPED = {"controller": "the shipped one"}


def with_sums(checkpoints):
    """Return checkpoints by role, with the shipped controller's sum instead of its words."""
    if checkpoints.get("controller") != SHIPPED["controller"]:
        return checkpoints
    return checkpoints | {"controller": sha256(CHECKPOINTS.shipped.read_bytes()).hexdigest()}


def made(out, demonstration, folder=PARTS, **header):
    """Write a demonstration's part as if it had been made so."""
    episode = random_episode(demonstration.seed)
    header = {"kind": demonstration.kind} | header
    if "checkpoints" in header:
        header["checkpoints"] = with_sums(header["checkpoints"])
    path = part_path(demonstration, out, folder)
    path.parent.mkdir(exist_ok=True, parents=True)
    path.write_bytes(part_bytes(replace(episode, header=replace(episode.header, **header))))


@pytest.mark.parametrize(
    ("mix", "header", "option"),
    [
        ("nominal", {"sense": "exact"}, "--sense tracked"),
        ("turns", {"sense": "tracked", "checkpoints": {"controller": "other"}}, "--checkpoint"),
        (
            "rollouts",
            {"sense": "tracked", "checkpoints": SHIPPED | {"planner": "one"}},
            "--planner-checkpoint",
        ),
    ],
)
@pytest.mark.parametrize("folder", [PARTS, FAILED])
def test_episodes_that_were_made_otherwise_are_not_joined(
    tmp_path, capfd, mix, header, option, folder
):
    (one,) = demonstrations(mix, 0, 1)
    made(tmp_path, one, folder, **header)
    words = ["collect", "--out", str(tmp_path), "--mix", mix, "--episodes", "1"]
    line = complaint(capfd, main(words), tmp_path)
    assert line.startswith(f"calot: {option}: ")
    assert "name the same, or choose another --out" in line


@pytest.mark.parametrize(
    ("mix", "header"),
    [
        ("nominal", {"sense": "tracked"}),
        ("turns", {"sense": "tracked", "checkpoints": SHIPPED}),
        ("turns", {}),
        ("nominal", {"sense": "tracked", "kind": "turns", "checkpoints": {"controller": "other"}}),
    ],
    ids=["the same", "the same checkpoint", "unknown", "of another kind"],
)
def test_episodes_that_were_made_likewise_or_nobody_knows_how_are_joined(tmp_path, mix, header):
    (one,) = demonstrations(mix, 0, 1)
    made(tmp_path, one, **header)
    assert main(["collect", "--out", str(tmp_path), "--mix", mix, "--episodes", "1"]) == 0


def test_a_demonstration_tells_by_which_checkpoints_it_is(tmp_path):
    checkpoint, planner = tmp_path / "policy", tmp_path / "planner"
    checkpoint.write_bytes(b"weights")
    planner.write_bytes(b"other weights")
    its_own = {"controller": sha256(b"weights").hexdigest()}
    (turn,) = demonstrations("turns", 0, 1, checkpoint=str(checkpoint))
    (rollout,) = demonstrations("rollouts", 0, 1, checkpoint=str(checkpoint), planner=str(planner))
    assert checkpoints_of(ASKED[0]) == {}
    assert checkpoints_of(demonstrations("turns", 0, 1)[0]) == with_sums(SHIPPED)
    assert checkpoints_of(turn) == its_own
    other = {"planner": sha256(b"other weights").hexdigest()}
    assert checkpoints_of(rollout) == its_own | other


@pytest.mark.parametrize(
    ("mix", "parts", "kept"),
    [("nominal", 1, "kept separately"), ("rollouts", 2, "kept with the others")],
)
def test_it_says_where_those_that_failed_are_kept(tmp_path, capfd, monkeypatch, mix, parts, kept):
    passed = random_episode(0)
    failed = replace(passed, header=replace(passed.header, success=False))
    episodes = iter((passed, failed))
    monkeypatch.setattr(of_demonstrations, "run", lambda demonstration, part: next(episodes))
    assert main(["collect", "--out", str(tmp_path), "--mix", mix, "--episodes", "2"]) == 0
    assert len(list((tmp_path / PARTS).glob("*.parquet"))) == parts
    assert f"1 passed, 1 failed and are {kept}" in capfd.readouterr().out


def test_the_trace_of_an_error_does_not_outlast_it(tmp_path, monkeypatch):
    def breaks(demonstration, part):
        raise RuntimeError("a string snapped")

    monkeypatch.setattr(of_demonstrations, "run", breaks)
    assert demonstrate(ASKED[0], tmp_path).error == "RuntimeError: a string snapped"
    (trace,) = (tmp_path / ERRORS).iterdir()
    assert "in breaks" in trace.read_text()
    monkeypatch.setattr(of_demonstrations, "run", lambda demonstration, part: random_episode(0))
    assert demonstrate(ASKED[0], tmp_path).success
    assert not trace.exists()


@pytest.mark.parametrize("success", [True, False])
def test_files_that_cannot_be_moved_or_removed_are_told_as_those_that_cannot_be_written(
    tmp_path, monkeypatch, success
):
    """A folder lies where the trace would, a file where the folder of failed ones would."""
    (tmp_path / ERRORS / f"{ASKED[0].name}.txt" / "inside").mkdir(parents=True)
    (tmp_path / FAILED).touch()
    episode = random_episode(0)
    episode = replace(episode, header=replace(episode.header, success=success))
    monkeypatch.setattr(of_demonstrations, "run", lambda demonstration, part: episode)
    outcome = demonstrate(ASKED[0], tmp_path)
    assert outcome.error is None
    path = part_path(ASKED[0], tmp_path, PARTS if success else FAILED)
    assert outcome.unwritable in (f"{path}: Is a directory", f"{path}: File exists")


def complaint(capfd, code, out):
    assert code == 2
    said = capfd.readouterr().err.splitlines()
    (line,) = (one for one in said if one and not one.startswith("Warp "))  # at its first start
    assert line.startswith("calot: ")
    assert str(out) in line
    return line


def test_a_damaged_part_is_one_clear_line_and_the_old_dataset_stays(out, capfd):
    collect(out)
    before = contents(out)
    path = part_path(ASKED[2], out)
    path.write_bytes(path.read_bytes()[:-50])
    capfd.readouterr()
    complaint(capfd, collect(out), path)
    assert contents(out) == before


def test_a_full_disk_is_one_clear_line_and_nothing_whole_is_lost(out, capfd, request):
    collect(out)
    before, there = contents(out), sorted(out.rglob("*"))
    capfd.readouterr()
    request.getfixturevalue("full_disk")
    assert "File too large" in complaint(capfd, collect(out), out)
    assert contents(out) == before
    assert sorted(out.rglob("*")) == there


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], ["--out"]),
        (["--out", "d", "--mix", "some"], ["--mix", "'some'", "nominal", "recovery"]),
        (["--out", "d", "--seed", "9990", "--episodes", "11"], ["--seed", "training", "9999"]),
        (
            ["--out", "d", "--seed", "9990", "--artery-below-mm", "16", "--mix", "nominal"],
            ["--artery-below-mm 16", "artery is shorter than 16 mm", "training seeds, 0 to 9999"],
        ),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing_behind(capfd, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    line = complaint(capfd, main(["collect", *words]), "")
    assert all(word in line for word in said)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_in_one_go_or_bit_by_bit_the_dataset_is_the_same(tmp_path):
    assert collect(tmp_path / "one go", episodes=2, workers=2) == 0
    assert collect(tmp_path / "by and by", episodes=1) == 0
    assert collect(tmp_path / "by and by", episodes=2) == 0
    assert contents(tmp_path / "by and by") == contents(tmp_path / "one go")


@pytest.mark.slow
def test_an_episode_that_finds_no_room_says_so_and_leaves_no_half_file(tmp_path, full_disk):
    outcome = demonstrate(PlannedDemonstration(seed=0, kind="nominal:textbook"), tmp_path)
    assert "File too large" in (outcome.unwritable or "")
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    assert replace(outcome, unwritable=None).success is False
