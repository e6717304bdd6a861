"""Tests of a report's folder: it holds only episodes of one version and of the same arms."""

import json
from pathlib import Path

import pytest

from scenarios.catalogue import CONTROLLERS, PolicyEntry
from scenarios.evaluation.arm import arm_from_text
from scenarios.evaluation.case import attempt
from scenarios.evaluation.folder import MANIFEST, finished, note, open_folder
from scenarios.files.errors import BadInputError
from scenarios.loop.results import write_results
from tests.scenarios.breaking_controller import BREAKS
from tests.scenarios.evaluation.made_up import FIRST, SECOND, episode, plan, record


def test_a_folder_is_used_again_and_gains_arms(tmp_path):
    open_folder(tmp_path, [FIRST])
    open_folder(tmp_path, [FIRST, SECOND])
    assert set(json.loads((tmp_path / MANIFEST).read_text())["arms"]) == {"first", "second"}


@pytest.mark.parametrize("name", ["world version", "recording schema", "source", "numpy"])
def test_a_folder_of_another_version_is_refused_and_stays(tmp_path, name):
    open_folder(tmp_path, [FIRST])
    manifest = json.loads((tmp_path / MANIFEST).read_text())
    manifest["made_with"][name] = "another"
    (tmp_path / MANIFEST).write_text(json.dumps(manifest))
    with pytest.raises(BadInputError, match=f"are of {name} another, this is .*another folder"):
        open_folder(tmp_path, [FIRST])
    assert json.loads((tmp_path / MANIFEST).read_text()) == manifest


@pytest.mark.parametrize("content", ["", "[]", '{"schema": 1}', '{"schema": 99}'])
def test_a_manifest_that_cannot_be_read_is_refused(tmp_path, content):
    (tmp_path / MANIFEST).write_text(content)
    with pytest.raises(BadInputError, match="name another folder"):
        open_folder(tmp_path, [FIRST])


def test_an_arm_that_was_another_one_is_refused(tmp_path):
    open_folder(tmp_path, [FIRST])
    with pytest.raises(BadInputError, match="arm 'first' was another one"):
        open_folder(tmp_path, [arm_from_text("first=scripted+expert,filter=off")])


def test_a_checkpoint_is_known_by_what_is_in_it(tmp_path):
    checkpoint = tmp_path / "policy.safetensors"
    checkpoint.write_bytes(b"weights")
    arm = arm_from_text(f"learned=scripted+diffusion,checkpoint={checkpoint}")
    open_folder(tmp_path / "out", [arm])
    open_folder(tmp_path / "out", [arm])
    checkpoint.write_bytes(b"other weights")
    with pytest.raises(BadInputError, match="arm 'learned' was another one"):
        open_folder(tmp_path / "out", [arm])


MINE = arm_from_text("mine=scripted+my_policy:make")


def written(folder, files):
    for name, code in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(code)


@pytest.mark.parametrize(
    ("files", "edited"),
    [
        ({"my_policy.py": "make = 1"}, "my_policy.py"),
        (
            {"my_policy/__init__.py": "make = 1", "my_policy/nets/deep.py": "a"},
            "my_policy/nets/deep.py",
        ),
        ({"my_policy/policy.py": "make = 1"}, "my_policy/policy.py"),
    ],
    ids=["a module", "a package", "a folder without __init__.py"],
)
def test_a_users_policy_is_known_by_its_code(tmp_path, monkeypatch, files, edited):
    monkeypatch.syspath_prepend(tmp_path)
    written(tmp_path, files)
    open_folder(tmp_path / "out", [FIRST, MINE])
    open_folder(tmp_path / "out", [FIRST, MINE])
    written(tmp_path, {edited: "other code"})
    with pytest.raises(BadInputError, match="arm 'mine' was another one"):
        open_folder(tmp_path / "out", [FIRST, MINE])
    open_folder(tmp_path / "out", [FIRST])


def test_a_policy_of_a_module_without_a_file_is_refused(tmp_path):
    with pytest.raises(BadInputError, match="the module sys has no file"):
        open_folder(tmp_path, [arm_from_text("mine=scripted+sys:getsizeof")])


def test_a_folder_that_does_not_tell_the_code_of_a_users_policy_is_refused(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    written(tmp_path, {"my_policy.py": "make = 1"})
    open_folder(tmp_path / "out", [MINE])
    path = tmp_path / "out" / MANIFEST
    manifest = json.loads(path.read_text())
    del manifest["arms"]["mine"]["controller code"]
    path.write_text(json.dumps(manifest))
    with pytest.raises(BadInputError, match="arm 'mine' was another one"):
        open_folder(tmp_path / "out", [MINE])


def test_a_language_model_is_known_by_its_name(tmp_path, monkeypatch):
    monkeypatch.setenv("CALOT_LLM_URL", "https://host/v1")
    arm = arm_from_text("talker=llm+expert")
    for model in ("small", "small"):
        monkeypatch.setenv("CALOT_LLM_MODEL", model)
        open_folder(tmp_path, [arm])
    monkeypatch.setenv("CALOT_LLM_MODEL", "large")
    with pytest.raises(BadInputError, match="arm 'talker' was another one"):
        open_folder(tmp_path, [arm])


def test_an_episode_recorded_to_its_end_is_finished_and_read_back(tmp_path):
    whole, broken, missing = plan("nominal", arms=(FIRST,), seeds=range(3)).due({})
    result = episode(whole, passed=False, chance=0.3)
    record(whole, tmp_path, result)
    record(broken, tmp_path)
    found = finished(tmp_path, plan("nominal", arms=(FIRST,), seeds=range(3)))
    assert found == {whole: result}
    assert missing not in found


def test_a_damaged_recording_is_named(tmp_path):
    (case,) = plan("nominal", arms=(FIRST,), seeds=[0]).due({})
    record(case, tmp_path, episode(case))
    (tmp_path / case.recording).write_bytes(b"PK no more")
    with pytest.raises(BadInputError, match=r"0\.npz is damaged.*remove it"):
        finished(tmp_path, plan("nominal", arms=(FIRST,), seeds=[0]))


def test_an_episode_that_breaks_off_is_an_error_and_is_run_again(tmp_path, monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    some = plan("textbook", arms=(arm_from_text("a=scripted+breaks"),), seeds=[10_004])
    (case,) = some.due({})
    _, ended = attempt(case, tmp_path)
    assert ended.result.error == "RuntimeError: a string snapped"
    assert ended.unwritable is None
    assert finished(tmp_path, some) == {}


def test_a_full_disk_is_reported_and_the_rest_stays(tmp_path, monkeypatch, request):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    (case,) = plan("nominal", arms=(arm_from_text("a=scripted+breaks"),), seeds=[10_004]).due({})
    (tmp_path / "kept").write_text("kept")
    request.getfixturevalue("full_disk")
    _, ended = attempt(case, tmp_path)
    assert "File too large" in (ended.unwritable or "")
    assert not (tmp_path / case.recording).exists()
    assert (tmp_path / "kept").read_text() == "kept"


def test_a_recording_that_somebody_moves_away_was_saved_and_is_run_again(tmp_path, monkeypatch):
    monkeypatch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=BREAKS))
    some = plan("nominal", arms=(arm_from_text("a=scripted+breaks"),), seeds=[10_004])
    (case,) = some.due({})
    out, replace = tmp_path / "out", Path.replace

    def move_away(written, target):
        replace(written, target)
        if Path(target).suffix == ".npz":
            out.rename(tmp_path / "gone")

    monkeypatch.setattr(Path, "replace", move_away)
    _, ended = attempt(case, out)
    assert ended.unwritable is None
    note(out, case)
    write_results(out / "results.json", [ended.result], config={})
    assert finished(out, some) == {}
