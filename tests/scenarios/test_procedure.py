"""Tests of procedures as data: one from outside runs, and no other room compares a kind's name."""

import ast
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from controller.expert.skills import SKILLS
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY, TASKS
from planner.procedure.outcomes import OUTCOMES
from planner.procedure.procedure import Procedure
from planner.procedure.task_kind import KINDS
from planner.scene.observed_outcomes import OBSERVED, is_done
from scenarios.loop.episode_config import EpisodeConfig
from tests.planner.observations import clipped
from tissue_sim.tools.instruments import INSTRUMENTS, right_tools

ROOT = Path(__file__).parents[2]
OUTSIDE = "tests.scenarios.touching:TOUCHING"
PATIENT = ("--scenario", "textbook", "--seed", "10004")
ROOMS = ("planner/procedure", "planner/scene/observed_outcomes.py", "controller/expert/skills.py")
LANGUAGE = "planner/language"  # its words for slots are kinds' names, too


def calot(*words: str) -> "subprocess.CompletedProcess[str]":
    """Run the command in a process of its own, as an outside procedure adds to global tables."""
    return subprocess.run(
        [sys.executable, "-m", "scenarios.cli", *words], cwd=ROOT, capture_output=True, text=True
    )


@pytest.fixture(scope="module", name="touched")
def _touched(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("touched")
    who = ("--planner", "scripted", "--controller", "expert", "--procedure", OUTSIDE)
    run = calot("run", *PATIENT, *who, "--out", str(out))
    assert run.returncode == 0, run.stderr
    return out


def test_a_kind_a_tool_and_a_procedure_from_outside_run(touched: Path) -> None:
    (result,) = json.loads((touched / "results.json").read_text())["episodes"]
    assert result["success"]
    assert result["procedure"] == OUTSIDE
    assert [(t["instruction"], t["success"]) for t in result["tasks"]] == [
        ("grabbing gallbladder", True),
        ("touching left tube", True),
        ("going back left tube", True),
    ]
    assert result["injuries"] == []


def test_its_recording_replays_only_where_its_code_is_named(touched: Path) -> None:
    recording = str(touched / "episodes" / "10004.npz")
    for ways in ((), ("--verify",)):
        refused = calot("replay", recording, *ways)
        assert refused.returncode == 2
        assert f"give --procedure {OUTSIDE}" in refused.stderr
        assert calot("replay", recording, *ways, "--procedure", OUTSIDE).returncode == 0


def test_policies_that_know_one_procedure_are_refused_for_another() -> None:
    with pytest.raises(ValueError, match="'learned' knows the procedure 'cholecystectomy' alone"):
        EpisodeConfig(procedure=OUTSIDE)
    with pytest.raises(ValueError, match="allowed: cholecystectomy, MODULE:PROCEDURE"):
        EpisodeConfig(procedure="appendectomy")


def test_every_kind_has_its_entries_and_an_unknown_kind_is_told() -> None:
    assert KINDS.keys() == OUTCOMES.keys() == SKILLS.keys()
    assert KINDS.keys() - OBSERVED.keys() == {name for name, kind in KINDS.items() if kind.grasps}
    with pytest.raises(ValueError, match="no entry for tasks of the kind 'touch'; there are: clip"):
        is_done(replace(TASKS[1], kind="touch"), clipped())


def test_a_procedure_that_cannot_be_carried_out_is_refused() -> None:
    clip, back = TASKS[1:3]
    for tasks in (
        (),
        (clip, back),  # indices
        (replace(clip, index=1), replace(clip, index=2)),  # words, and no retraction
        (replace(back, index=1), replace(clip, index=2)),
        (replace(TASKS[0], index=1),),
    ):
        with pytest.raises(ValueError, match="procedure 'odd'"):
            Procedure(name="odd", tasks=tasks)
    two = Procedure(name="clip", tasks=(replace(clip, index=1), replace(back, index=2)))
    assert two.after(two.tasks[0]) == two.tasks[1]


def test_a_procedure_with_cuts_ends_once_all_its_cuts_are_seen() -> None:
    left_cut, right_cut = (CHOLECYSTECTOMY.of("cut", side, None) for side in ("left", "right"))
    for cut in (left_cut, right_cut):
        back = CHOLECYSTECTOMY.after(cut)
        assert CHOLECYSTECTOMY.may_end_with(back, {"left": True, "right": True})
        assert not CHOLECYSTECTOMY.may_end_with(back, {"left": True, "right": False})
        assert not CHOLECYSTECTOMY.may_end_with(cut, {"left": True, "right": True})


def test_every_right_tool_is_an_instrument_of_the_right_arm() -> None:
    assert {task.right_tool for task in TASKS} <= set(right_tools()) < INSTRUMENTS.keys()


def _names_a_kind(node: ast.AST) -> bool:
    """Return whether code compares `.kind` with a kind's name, or takes a task by its number."""
    if isinstance(node, ast.Compare):
        parts = (node.left, *node.comparators)
        of_kind = any(isinstance(part, ast.Attribute) and part.attr == "kind" for part in parts)
        words = {w.value for p in parts for w in ast.walk(p) if isinstance(w, ast.Constant)}
        return of_kind and bool(words & KINDS.keys())
    if isinstance(node, ast.Constant):
        return node.value in KINDS.keys() - {"grab", "clip", "cut"}  # the others are plain words
    if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
        return node.value.id == "TASKS" and isinstance(node.slice, ast.Constant)
    return False


def test_no_other_room_compares_a_kind_or_takes_a_task_by_its_number() -> None:
    named = [
        f"{file.relative_to(ROOT)}:{getattr(node, 'lineno', 0)}"
        for package in ("tissue_sim", "planner", "controller", "scenarios")
        for file in (ROOT / package).rglob("*.py")
        if not str(file.relative_to(ROOT)).startswith((*ROOMS, LANGUAGE))
        for node in ast.walk(ast.parse(file.read_text()))
        if _names_a_kind(node)
    ]
    assert named == []
