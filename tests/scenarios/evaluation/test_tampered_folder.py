"""Tests of an evaluation's folder that somebody edited: no edit reaches the report."""

import json

import numpy as np
import pytest

from scenarios.evaluation.arm import arm_from_text
from scenarios.evaluation.folder import MANIFEST, finished, note, open_folder
from scenarios.files.errors import BadInputError
from scenarios.files.sums import SUMS
from tests.scenarios.evaluation.made_up import FIRST, SECOND, episode, plan, record
from tests.scenarios.recording.tampering import tampered

PLAN = plan("nominal", arms=(FIRST, SECOND), seeds=range(20_000, 20_002))
CASES = PLAN.due({})


@pytest.fixture
def folder(tmp_path):
    """Return a folder with four finished episodes, of which each may be edited."""
    open_folder(tmp_path, [FIRST, SECOND])
    for case in CASES:
        record(case, tmp_path, episode(case, passed=case.seed == 20_000))
        note(tmp_path, case)
    return tmp_path


def edited(folder, edit, *, noted=False):
    path = folder / CASES[0].recording
    tampered(path, path, edit)
    if noted:  # as somebody would who knows of the list, too
        note(folder, CASES[0])


def refused(folder):
    with pytest.raises(BadInputError) as told:
        finished(folder, PLAN)
    assert "\n" not in str(told.value)
    return str(told.value)


def test_what_was_not_edited_is_finished(folder):
    assert len(finished(folder, PLAN)) == 4


def test_a_list_whose_last_line_was_cut_short_is_read(folder):
    (folder / SUMS).write_text((folder / SUMS).read_text()[:-20])
    assert len(finished(folder, PLAN)) == 4


RESULT = {
    "success": {"success": False},
    "success is text": {"success": "yes"},
    "a call": {"call": {"reason": "x", "in_time": True, "needed": True}},
    "a time": {"procedure_time_s": None},
    "a seed": {"seed": 20_001},
    "tasks": {"tasks": []},
    "tasks null": {"tasks": None},
    "an injury": {"injuries": [{"event": "leak"}]},
    "interventions": {"safety": {"filter": True, "interventions": 0}},
    "dropped clips": {"dropped_clips": 2},
}


@pytest.mark.parametrize("change", RESULT.values(), ids=RESULT)
def test_an_edited_result_is_refused_although_the_hash_in_the_file_fits(folder, change):
    edited(folder, lambda header, arrays: header["result"].update(change))
    assert str(CASES[0].recording) in refused(folder)


def config(**changes):
    def edit(header, arrays):
        header["config"].update(changes)
        for name in header["result"].keys() & changes.keys():
            header["result"][name] = changes[name]

    return edit


ANOTHER = {
    "another seed": config(seed=20_001),
    "another planner": config(planner="learned"),
    "another controller": config(controller="idle"),
    "another scenario": config(scenario="textbook"),
    "an outside controller": config(controller="my_own:make"),
    "without a filter": config(safety_filter=False),
    "another sense": config(sense="exact", task_cap_s=1.0),
    "other checkpoints": lambda header, arrays: header["checkpoints"].update(planner="0" * 64),
    "another patient": lambda header, arrays: header.update(anatomy={"seed": 3}),
    "another world": lambda header, arrays: header.update(world_version=1),
    "NaN": lambda header, arrays: arrays["time_s"].__setitem__(3, np.nan),
    "half the steps": lambda header, arrays: arrays.update({k: a[:9] for k, a in arrays.items()}),
    "success with an injury": lambda header, arrays: header["result"].update(
        injuries=[{"event": "leak", "time_s": 1.0, "value": 1.0, "limit": 0.0}]
    ),
}


@pytest.mark.parametrize("edit", ANOTHER.values(), ids=ANOTHER)
def test_a_recording_of_another_episode_is_refused_although_every_hash_fits(folder, edit):
    edited(folder, edit, noted=True)
    assert str(CASES[0].recording) in refused(folder)


def test_one_patient_does_not_stand_for_another(folder):
    first, second = (folder / case.recording for case in CASES[:2])
    second.write_bytes(first.read_bytes())
    assert "20001" in refused(folder)
    (folder / SUMS).unlink()
    assert "is of seed 20000, not 20001" in refused(folder)


@pytest.mark.parametrize(
    "change",
    [
        {"schema": "1"},
        {"schema": None},
        {"made_with": None},
        {"made_with": []},
        {"arms": None},
        {"arms": {"first": 3}},
        {"arms": [1]},
    ],
)
def test_an_edited_manifest_is_refused(folder, change):
    path = folder / MANIFEST
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(BadInputError):
        open_folder(folder, [FIRST])


@pytest.mark.parametrize("text", ["[" * 100_000, '{"a":' * 100_000, "\xff", "NaN", "3", "null"])
def test_a_manifest_that_is_none_is_refused(tmp_path, text):
    (tmp_path / MANIFEST).write_text(text)
    with pytest.raises(BadInputError, match="is damaged; name another folder"):
        open_folder(tmp_path, [arm_from_text("first=scripted+expert")])


def test_a_damaged_list_is_refused(folder):
    (folder / SUMS).write_text("nonsense\n")
    assert "SHA256SUMS, line 1" in refused(folder)
