"""Tests of a report's folder: it holds only episodes of one version and of the same arms."""

import json

import pytest

from scenarios.catalogue import CONTROLLERS
from scenarios.evaluation.arm import arm_from_text
from scenarios.evaluation.case import attempt
from scenarios.evaluation.folder import MANIFEST, finished, open_folder
from scenarios.files.errors import BadInputError
from tests.scenarios.evaluation.made_up import FIRST, SECOND, episode, plan, record

BREAKS = "tests.scenarios.breaking_controller:ControllerBreaks"


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
    monkeypatch.setitem(CONTROLLERS, "breaks", BREAKS)
    some = plan("textbook", arms=(arm_from_text("a=scripted+breaks"),), seeds=[10_004])
    (case,) = some.due({})
    ended = attempt(case, tmp_path)
    assert ended.result.error == "RuntimeError: a string snapped"
    assert ended.unwritable is None
    assert finished(tmp_path, some) == {}


def test_a_full_disk_is_reported_and_the_rest_stays(tmp_path, monkeypatch, request):
    monkeypatch.setitem(CONTROLLERS, "breaks", BREAKS)
    (case,) = plan("nominal", arms=(arm_from_text("a=scripted+breaks"),), seeds=[10_004]).due({})
    (tmp_path / "kept").write_text("kept")
    request.getfixturevalue("full_disk")
    ended = attempt(case, tmp_path)
    assert "File too large" in (ended.unwritable or "")
    assert not (tmp_path / case.recording).exists()
    assert (tmp_path / "kept").read_text() == "kept"
