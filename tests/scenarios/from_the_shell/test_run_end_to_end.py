"""Tests of `calot run` from the shell: results, recording and report of a procedure."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from scenarios.recording.recorder import load
from tests.scenarios.example_results import read_results
from tests.scenarios.procedures import SEED_BY_COMMAND
from tissue_sim.patient.textbook import textbook_from_seed

TASKS = CHOLECYSTECTOMY.tasks_with(textbook_from_seed(SEED_BY_COMMAND).tubes)
CONTRACT: dict[str, set[str]] = {  # what results.json promises its readers
    "document": {"episodes", "summary", "recordings", "config", "versions"},
    "episode": {
        *("scenario", "seed", "planner", "controller", "sense", "privileged", "sensing"),
        *("success", "call", "error", "tasks"),
        *("procedure_time_s", "exchange_time_s", "wall_s", "corrections"),
        *("dropped_clips", "injuries", "peaks", "safety"),
        *("anatomy_hash", "tubes", "act", "rules", "procedure"),
    },
    "task": {
        *("index", "instruction", "success", "time_s", "corrections"),
        *("path_m", "jerk_m_s3", "failure_chance", "alarm_s", "left_out"),
    },
    "safety": {"filter", "interventions", "min_clearance_m", "ledger"},
    "summary": {
        *("episodes", "passed", "called", "needless", "errors", "pass_rate"),
        "wilson_95",
    },
}


@pytest.fixture(scope="module")
def out(ran_by_command) -> Path:
    return ran_by_command[0]


@pytest.fixture(scope="module")
def finished(ran_by_command) -> subprocess.CompletedProcess[str]:
    return ran_by_command[1]


@pytest.fixture(scope="module")
def document(out, finished) -> dict[str, Any]:
    def refuse(word: str) -> None:
        raise ValueError(f"{word} is not JSON")

    return json.loads((out / "results.json").read_text(), parse_constant=refuse)


def test_a_passed_run_exits_with_0(finished):
    assert finished.returncode == 0, finished.stderr


def test_the_report_has_a_row_a_task_and_the_pass_rate(out, finished):
    rows = [line.split("│") for line in finished.stdout.splitlines() if line.startswith("│")]
    said = [
        (int(row[1]), row[2].strip(), row[3].strip()) for row in rows if row[1].strip().isdigit()
    ]
    assert said == [(task.index, task.text, "yes") for task in TASKS]
    assert "passed 1 of 1" in finished.stdout
    assert str(out / "results.json") in finished.stdout


def test_results_json_keeps_the_contract(document):
    (episode,) = document["episodes"]
    found = {
        "document": document,
        "episode": episode,
        "task": episode["tasks"][0],
        "safety": episode["safety"],
        "summary": document["summary"],
    }
    assert {name: set(entry) for name, entry in found.items()} == CONTRACT
    assert episode["seed"] == document["config"]["seed"] == SEED_BY_COMMAND
    assert (episode["success"], episode["error"], episode["injuries"]) == (True, None, [])
    assert episode["anatomy_hash"] == textbook_from_seed(SEED_BY_COMMAND).hash
    summary = document["summary"]
    assert (summary["episodes"], summary["passed"], summary["errors"]) == (1, 1, 0)
    assert summary["wilson_95"][0] < summary["pass_rate"] == 1.0


def test_the_result_is_read_back_and_recorded_beside_the_steps(out, document):
    (result,) = read_results(out / "results.json")
    recording = load(out / "episodes" / f"{SEED_BY_COMMAND}.npz")
    assert recording.result == document["episodes"][0]
    assert len(recording.instructions) == len(TASKS)
    assert result.procedure_time_s + result.exchange_time_s == pytest.approx(
        recording.arrays["time_s"][-1]
    )
