"""Tests of procedures as data: one from outside runs, and no other room compares a kind's name."""

import ast
import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from controller.expert.controller import ControllerExpert
from controller.expert.skills import SKILLS
from planner.base import PATIENCE_S
from planner.command import COMMANDS
from planner.instruction import Instruction
from planner.person.answers import answer
from planner.person.orders import Order, OrderProgress
from planner.person.override import PlannerOverridden
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY, TASKS
from planner.procedure.outcomes import OUTCOMES, is_needed, task_over
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.procedure.task_kind import KINDS, TaskKind
from planner.scene.observed_outcomes import OBSERVED, is_done
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from tests.planner.observations import clipped
from tests.scenarios.from_the_shell.complaint import complaint
from tests.worlds import textbook_world
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.patient.variants import variant
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.instruments import CLIP_APPLIER, GRASPER, INSTRUMENTS, SCISSORS, right_tools

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


@pytest.mark.slow
def test_its_recording_replays_only_where_its_code_is_named(touched: Path) -> None:
    recording = str(touched / "episodes" / "10004.npz")
    for ways in ((), ("--verify",)):
        refused = calot("replay", recording, *ways)
        assert refused.returncode == 2
        assert f"give --procedure {OUTSIDE}" in refused.stderr
        assert calot("replay", recording, *ways, "--procedure", OUTSIDE).returncode == 0


def test_policies_that_know_one_procedure_are_refused_for_another() -> None:
    with pytest.raises(ValueError, match="'learned' knows the procedure 'cholecystectomy' alone"):
        EpisodeConfig(procedure=OUTSIDE, planner="learned")
    with pytest.raises(ValueError, match="allowed: cholecystectomy, MODULE:PROCEDURE"):
        EpisodeConfig(procedure="appendectomy")


def test_every_kind_has_its_entries_and_an_unknown_kind_is_told() -> None:
    assert KINDS.keys() == OUTCOMES.keys() == SKILLS.keys()
    assert KINDS.keys() - OBSERVED.keys() == {name for name, kind in KINDS.items() if kind.grasps}
    with pytest.raises(ValueError, match="OBSERVED has no entry for the kind 'touch'"):
        is_done(replace(TASKS[1], kind="touch"), clipped())


IMPOSSIBLE = {
    "no tube": {"tube": None},
    "another tube": {"tube": "duct"},
    "a clip of no tube": {"clip": 7},
    "no clip": {"clip": None},
    "a clip in words": {"clip": "1"},
    "scissors that clip": {"right_tool": SCISSORS},
    "the left tool": {"right_tool": GRASPER},
    "an unknown tool": {"right_tool": "hammer"},
    "an unknown kind": {"kind": "dissect"},
    "no words": {"text": " "},
    "two lines": {"text": "clip\nit"},
    "another place": {"index": 2},
    "no retraction": {"kind": "go_back"},
}


@pytest.mark.parametrize("change", IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_a_procedure_that_cannot_be_carried_out_is_refused(change: dict[str, Any]) -> None:
    clip, back = (replace(task, index=k) for k, task in enumerate(TASKS[1:3], start=1))
    assert Procedure(name="whole", tasks=(clip, back)).after(clip) == back
    lone = (replace(clip, index=1), replace(TASKS[0], index=2, kind="clip", tube="left", clip=1))
    tasks = lone if change == {"kind": "go_back"} else (replace(clip, **change), back)
    with pytest.raises(ValueError, match="procedure 'odd': ") as told:
        Procedure(name="odd", tasks=tasks)
    assert len(str(told.value).splitlines()) == 1


@pytest.mark.parametrize("tasks", [(), list(TASKS), TASKS[:1], tuple("ab")])
def test_tasks_that_are_no_procedure_are_refused(tasks: Any) -> None:
    with pytest.raises(ValueError, match="procedure 'odd': "):
        Procedure(name="odd", tasks=tasks)


@pytest.mark.parametrize(
    "body",
    [
        "",
        "P = 1",
        "def f(:",
        "raise KeyError('no licence')",
        "import sys; sys.exit(0)",
        "import gone",
    ],
)
def test_a_procedure_that_cannot_be_imported_is_told_in_one_line(
    body: str, tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "odd_procedure.py").write_text(body)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "odd_procedure", raising=False)
    who = ("--planner", "scripted", "--controller", "expert", "--procedure", "odd_procedure:P")
    assert "--procedure odd_procedure:P: " in complaint(capfd, "run", *who)


def test_failures_that_strike_a_task_are_refused_for_another_procedure() -> None:
    who = {**ORACLE, "procedure": OUTSIDE}
    with pytest.raises(ValueError, match="scenario 'grasp-slip' strikes a task of 'cholecyst"):
        EpisodeConfig(**who, scenario="grasp-slip")
    assert EpisodeConfig(**who, scenario="breathing").procedure == OUTSIDE


@pytest.fixture(name="waiting")
def _waiting(monkeypatch: pytest.MonkeyPatch) -> Procedure:
    """Return a procedure that waits above the tube before it clips: nothing stands behind."""
    monkeypatch.setitem(KINDS, "wait", TaskKind())
    monkeypatch.setitem(OBSERVED, "wait", lambda task, observation: False)
    wait = Task(index=1, text="waiting", kind="wait", tube="left", right_tool=CLIP_APPLIER)
    clip, back = (replace(task, index=k) for k, task in enumerate(TASKS[1:3], start=2))
    return Procedure(name="waiting", tasks=(wait, replace(clip, text="my clip"), back))


def test_an_ordered_task_without_a_retraction_begins_no_other_task(waiting: Procedure) -> None:
    progress = OrderProgress(Order(task=waiting.tasks[0]), clipped(), waiting)
    told = [
        progress.update(clipped(time_s=float(t)), exchanging=False, speed=1.0)
        for t in range(1, round(PATIENCE_S) + 2)
    ]
    assert progress.task == waiting.tasks[0]
    assert told[-1] == "Given up: waiting; something is in the way."


def test_what_is_said_of_a_task_means_the_procedures_own(waiting: Procedure) -> None:
    planner = PlannerOverridden(Waits(waiting), waiting)
    planner.plan(clipped())
    reply = planner.instruct(COMMANDS["clip left tube"], clipped()).reply
    assert reply.startswith("my clip, until it is done.")
    refused = planner.instruct(COMMANDS["grabbing gallbladder"], clipped())
    assert "waiting has no task 'grabbing gallbladder'" in refused.reply


def test_the_time_of_tasks_that_nobody_measured_is_not_told(waiting: Procedure) -> None:
    told = answer("left", Instruction(task=waiting.tasks[0]), clipped(), procedure=waiting)
    assert "nobody has measured" in told


class Waits:
    """A planner that gives the first task of a procedure."""

    def __init__(self, procedure: Procedure) -> None:
        self._task = procedure.tasks[0]

    def reset(self) -> None:
        """Do nothing."""

    def plan(self, observation: Observation) -> Instruction:
        return Instruction(task=self._task, time_s=observation.time_s)


def test_a_procedure_with_cuts_ends_once_all_its_cuts_are_seen() -> None:
    left_cut, right_cut = (CHOLECYSTECTOMY.of("cut", side, None) for side in ("left", "right"))
    for cut in (left_cut, right_cut):
        back = CHOLECYSTECTOMY.after(cut)
        assert CHOLECYSTECTOMY.may_end_with(back, {"left": True, "right": True})
        assert not CHOLECYSTECTOMY.may_end_with(back, {"left": True, "right": False})
        assert not CHOLECYSTECTOMY.may_end_with(cut, {"left": True, "right": True})


def test_a_third_tube_that_is_there_must_be_cut_too() -> None:
    done = {"left": True, "right": True}
    for back in (task for task in TASKS if task.goes_back):
        assert not CHOLECYSTECTOMY.may_end_with(back, done | {"third": False})
        assert CHOLECYSTECTOMY.may_end_with(back, done | {"third": True})


def test_a_patient_without_a_third_tube_has_exactly_the_17_tasks() -> None:
    assert CHOLECYSTECTOMY.tasks_with(("left", "right")) == TASKS[:17]
    assert CHOLECYSTECTOMY.tasks_with(("left", "right", "third")) == TASKS
    two = variant("two-arteries", textbook_from_seed(10_004))
    assert CHOLECYSTECTOMY.tasks_with(two.tubes) == TASKS
    assert CHOLECYSTECTOMY.tasks_with(textbook_from_seed(10_004).tubes) == TASKS[:17]


def test_a_task_on_a_tube_that_is_not_there_is_never_done_and_moves_nothing() -> None:
    world = textbook_world(10_004)
    expert = ControllerExpert(world)
    for task in (task for task in TASKS if task.is_optional):
        assert not is_needed(task, world)
        if task.is_deed:
            assert not task_over(task, world)
            (first, *_) = expert.act(world.observe(), Instruction(task=task))
            assert not first.move_endoscope_m.any()


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
