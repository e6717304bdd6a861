"""`calot run` as a person calls it: one whole procedure, its results, its record, its report."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from planner.instruction import TASKS
from scenarios.loop.results import read_results
from scenarios.recording.recorder import load
from tissue_sim.patient.anatomy import anatomy_from_seed

ROOT = Path(__file__).parents[2]
SEED = 10_004

CONTRACT: dict[str, set[str]] = {  # design.md, "Command line"
    "document": {"episodes", "summary", "config", "versions"},
    "episode": {
        *("scenario", "seed", "planner", "controller", "sense", "privileged"),
        *("success", "error", "tasks"),
        *("procedure_time_s", "exchange_time_s", "wall_s", "corrections"),
        *("dropped_clips", "injuries", "safety"),
        "anatomy_hash",
    },
    "task": {
        *("index", "instruction", "success", "time_s", "corrections"),
        *("path_m", "jerk_m_s3", "failure_chance", "alarm_s"),
    },
    "safety": {"filter", "interventions", "min_clearance_m", "ledger"},
    "summary": {"episodes", "passed", "errors", "pass_rate", "wilson_95"},
}


def run(out: Path) -> tuple[Path, subprocess.CompletedProcess[str]]:
    witness = ["--planner", "scripted", "--controller", "expert"]
    words = ["run", *witness, "--seed", str(SEED), "--out", str(out)]
    return out, subprocess.run(
        [sys.executable, "-m", "scenarios.cli", *words], cwd=ROOT, capture_output=True, text=True
    )


@pytest.fixture(scope="module")
def ran(made_once) -> tuple[Path, subprocess.CompletedProcess[str]]:
    return made_once("run", run)


@pytest.fixture(scope="module")
def out(ran) -> Path:
    return ran[0]


@pytest.fixture(scope="module")
def finished(ran) -> subprocess.CompletedProcess[str]:
    return ran[1]


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
    assert episode["seed"] == document["config"]["seed"] == SEED
    assert (episode["success"], episode["error"], episode["injuries"]) == (True, None, [])
    assert episode["anatomy_hash"] == anatomy_from_seed(SEED).hash
    summary = document["summary"]
    assert (summary["episodes"], summary["passed"], summary["errors"]) == (1, 1, 0)
    assert summary["wilson_95"][0] < summary["pass_rate"] == 1.0


def test_the_result_is_read_back_and_recorded_beside_the_steps(out, document):
    (result,) = read_results(out / "results.json")
    recording = load(out / "episodes" / f"{SEED}.npz")
    assert recording.result == document["episodes"][0]
    assert len(recording.instructions) == len(TASKS)
    assert result.procedure_time_s + result.exchange_time_s == pytest.approx(
        recording.arrays["time_s"][-1]
    )


def test_another_process_gives_the_same_procedure_bit_for_bit(out, finished, procedure):
    arrays = load(out / "episodes" / f"{SEED}.npz").arrays
    assert arrays.keys() == procedure.recording.arrays.keys()
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, procedure.recording.arrays[name])
