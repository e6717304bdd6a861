"""Tests of recordings that somebody edited: refused in one line, or found not to be identical."""

import sys
import zipfile
from itertools import islice

import numpy as np
import pytest

from scenarios.cli import main
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.recorder import HASH, HEADER, load
from tests.scenarios.from_the_shell.complaint import complaint
from tests.scenarios.recording.tampering import parts_of, tampered

IDLE = EpisodeConfig(
    planner="scripted", controller="idle", sense="exact", scenario="textbook", seed=10_008,
    task_cap_s=1.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    out = tmp_path_factory.mktemp("tampered")
    attempt_episode(IDLE, out)
    return out / "episodes" / "10008.npz"


def header(change):
    return lambda header, arrays: change(header)


def result(**changes):
    return header(lambda h: h["result"].update(changes))


def arrays(change):
    return lambda header, arrays: change(arrays)


def cut(n):
    return arrays(lambda a: a.update({name: array[:n] for name, array in a.items()}))


def put(name, index, value):
    return arrays(lambda a: a[name].__setitem__(index, value))


REFUSED = {
    **{f"no {k}": header(lambda h, k=k: h.pop(k)) for k in (
        "config", "versions", "world_version", "checkpoints", "anatomy", "instructions", "events",
        "perturbations", "ledger", "heard", "told", "hands", "result", "error", "schema_version",
    )},
    **{f"{k} null": header(lambda h, k=k: h.update({k: None})) for k in (
        "config", "versions", "instructions", "events", "heard", "hands", "ledger",
    )},
    "no scenario": header(lambda h: h["config"].pop("scenario")),
    "no seed": header(lambda h: h["config"].pop("seed")),
    "another controller": header(lambda h: h["config"].update(controller="expert")),
    "another seed": header(lambda h: h["config"].update(seed=10_009)),
    "no step of an event": header(lambda h: h["events"].append({"event": "leak"})),
    "a late event": header(lambda h: h["told"].append({"step": 999, "text": "Done."})),
    "task 99": header(lambda h: h["instructions"][0].update(task=99)),
    "no arm 7": header(lambda h: h["hands"].append(
        {"step": 0, "arm": 7, "T_world_goal": np.eye(4).tolist(), "jaw_rad": 0.1}
    )),
    "no button": header(lambda h: h["heard"].append({
        "step": 0, "time_s": 0.0, "text": "explode", "command": None, "then": [], "by": "button",
        "instruction": None, "reply": "",
    })),
    "success is yes": result(success="yes"),
    "success flipped": result(success=True),
    "no safety": result(safety=None),
    "a time that is text": result(procedure_time_s="long"),
    "half the steps": cut(10),
    "no steps": cut(0),
    "no joints": arrays(lambda a: a.pop("joints")),
    "an unknown array": arrays(lambda a: a.update(more=np.zeros(3))),
    "NaN commands": put("commands", 3, np.nan),
    "NaN forces": put("forces_n", 3, np.nan),
    "tool 7": put("right_tool", 3, 7),
    "tool -1": put("right_tool", 3, -1),
    "instruction 99": put("instruction", 3, 99),
    "clip -1": put("clip_loaded", 3, -1),
    "time backwards": arrays(lambda a: a.update(time_s=a["time_s"][::-1].copy())),
    "another type": arrays(lambda a: a.update(forces_n=a["forces_n"].astype(np.float32))),
    "another shape": arrays(lambda a: a.update(commands=a["commands"][:, 0])),
    "by columns": arrays(lambda a: a.update(joints=np.asfortranarray(a["joints"]))),
    "big endian": arrays(lambda a: a.update(time_s=a["time_s"].astype(">f8"))),
}  # fmt: skip


@pytest.mark.parametrize("edit", REFUSED.values(), ids=REFUSED)
def test_an_edited_recording_is_refused_in_one_line_although_its_hash_fits(
    recording, tmp_path, edit, capfd
):
    file = tampered(recording, tmp_path / "e.npz", edit)
    assert "damaged, or no recording" in complaint(capfd, "replay", str(file))
    assert "damaged, or no recording" in complaint(capfd, "replay", "--verify", str(file))


DIFFERENT = {
    "forces": put("forces_n", (3, 0, 0), 4.5),
    "joints": put("joints", (3, 0, 0), 0.1),
    "tips_endoscope": put("tips_endoscope", (3, 0, 0, 3), 0.1),
    "clip_loaded": put("clip_loaded", slice(3, None), 0),
    "dropped_clips": result(dropped_clips=3),
    "peaks": result(peaks=[]),
    "anatomy_hash": result(anatomy_hash="0123456789ab"),
    "tubes": result(tubes=["left", "right", "third"]),
    "right_tool": put("right_tool", slice(3, None), 1),
}


@pytest.mark.parametrize(("what", "edit"), DIFFERENT.items(), ids=DIFFERENT)
def test_what_was_changed_is_never_called_identical(recording, tmp_path, what, edit, capfd):
    file = tampered(recording, tmp_path / "e.npz", edit)
    assert main(["replay", str(file)]) in (1, 2)
    assert "identical" not in capfd.readouterr().out


def test_a_recording_that_is_as_it_was_saved_says_what_was_compared(recording, capfd):
    assert main(["replay", str(recording)]) == 0
    out = capfd.readouterr().out
    assert f"of {len(load(recording).arrays['time_s'])} steps, and how the patient is judged" in out
    assert "not compared: what the policies decided" in out


@pytest.mark.parametrize("name", ["sense", "privileged", "tasks"])
def test_verify_notices_what_the_result_no_longer_tells(recording, tmp_path, name, capfd):
    edit = header(lambda h: h["result"].pop(name))
    file = tampered(recording, tmp_path / "e.npz", edit)
    assert main(["replay", "--verify", str(file)]) == 1
    assert f"result, {name}" in capfd.readouterr().out


def rewritten(recording, target, change):
    """Write a copy with the old hash."""
    with np.load(recording) as file:
        content = {name: file[name].copy() for name in file}
    change(content)
    np.savez_compressed(target, **content)
    return target


def test_an_edit_without_a_new_hash_is_noticed(recording, tmp_path, capfd):
    file = rewritten(
        recording, tmp_path / "e.npz", lambda content: content["forces_n"].__setitem__(3, 0.5)
    )
    assert "changed after it was saved" in complaint(capfd, "replay", str(file))
    file = rewritten(recording, tmp_path / "e.npz", lambda content: content.pop(HASH))
    assert "content hash is missing" in complaint(capfd, "replay", str(file))


def as_schema_7(header, arrays):
    header["schema_version"] = 7
    del header["config"]["act_limit_s"]


def test_a_recording_of_schema_7_has_no_hash_and_is_read(recording, tmp_path):
    file = tampered(recording, tmp_path / "e.npz", as_schema_7)
    rewritten(file, file, lambda content: content.pop(HASH))
    assert load(file).sha256 is None
    assert load(recording).sha256 is not None


@pytest.mark.parametrize(
    "text",
    ["[" * 100_000, '{"a":' * 100_000, "NaN", '{"schema_version": 1e999}', "[]", "null", "7"],
    ids=["lists", "objects", "NaN", "infinite", "list", "null", "number"],
)
def test_a_header_that_is_no_header_is_refused_in_one_line(recording, tmp_path, text, capfd):
    file = rewritten(
        recording, tmp_path / "e.npz", lambda content: content.update({HEADER: np.array(text)})
    )
    assert "damaged, or no recording" in complaint(capfd, "replay", str(file))


def test_an_encrypted_member_is_refused_in_one_line(recording, tmp_path, capfd):
    content = bytearray(recording.read_bytes())
    content[content.index(b"PK\x01\x02") + 8] |= 1  # of the first member's flags
    (tmp_path / "e.npz").write_bytes(content)
    assert "encrypted" in complaint(capfd, "replay", str(tmp_path / "e.npz"))


def test_a_bomb_is_refused_before_it_is_unpacked(recording, tmp_path, capfd):
    bomb = tmp_path / "e.npz"
    with (
        zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as file,
        file.open("forces_n.npy", "w", force_zip64=True) as member,
    ):
        for _ in range(50):
            member.write(bytes(10_000_000))
    assert bomb.stat().st_size < 1_000_000
    assert "it unpacks to 0.50 GB; allowed" in complaint(capfd, "replay", str(bomb))


def test_one_bad_file_has_a_row_of_its_own(recording, tmp_path, capfd):
    (tmp_path / "good.npz").write_bytes(recording.read_bytes())
    tampered(recording, tmp_path / "bad.npz", REFUSED["events null"])
    for workers in ("1", "2"):
        assert main(["replay", "--verify", "--workers", workers, str(tmp_path)]) == 2
        assert "1 of 2 identical" in capfd.readouterr().out


def test_code_that_a_recording_names_runs_only_if_it_is_allowed(
    recording, tmp_path, monkeypatch, capfd
):
    mark = tmp_path / "ran"
    (tmp_path / "my_own.py").write_text(f"open({str(mark)!r}, 'w').close()\n")
    monkeypatch.syspath_prepend(tmp_path)

    def names_code(header, arrays):
        for part in (header["config"], header["result"]):
            part["controller"] = "my_own:make"

    file = tampered(recording, tmp_path / "e.npz", names_code)
    for words in ((), ("--controller", "another:make")):
        told = complaint(capfd, "replay", "--verify", str(file), *words)
        assert "give --controller my_own:make, or --trust" in told
        assert not mark.exists()
    for words in (("--controller", "my_own:make"), ("--trust",)):
        main(["replay", "--verify", str(file), *words])
        assert mark.exists()
        mark.unlink()
        sys.modules.pop("my_own", None)


def test_the_header_alone_is_read_quickly(recording):
    alone = load(recording, steps=False)
    assert alone.result == load(recording).result
    assert not alone.arrays
    assert list(islice(parts_of(recording)[1], 1)) == ["time_s"]
