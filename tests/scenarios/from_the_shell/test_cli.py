"""Tests of bad input: one line names what is allowed, exit code 2, and no files are left."""

import os
import subprocess
import sys
import tempfile
from dataclasses import replace
from io import BytesIO

import pytest

from scenarios.catalogue import ORACLE, PLANNERS, SCENARIOS, SENSE_OF
from scenarios.cli import main, parse
from scenarios.commands import policy_options
from scenarios.commands.folder_options import require_writable_folder
from scenarios.commands.run import Run, exit_code
from scenarios.files.errors import BadInputError
from scenarios.loop.episode_config import EpisodeConfig
from tests.scenarios.example_results import CALLED, ERROR, FAILED, NEEDLESS, PASSED
from tests.scenarios.from_the_shell.complaint import complaint

HEAVY = (
    "torch",
    "onnxruntime",
    "pyarrow",
    "sapien",
    "mani_skill",
    "warp",
    "casadi",
    "viser",
    "trimesh",
    "fcl",
    "ray",
)
DIFFUSION = ("run", "--controller", "diffusion")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["run", "--scenario", "zoo"], ["--scenario", "'zoo'", "nominal"]),
        (["run", "--planner", "oracle"], ["--planner", "'oracle'", "scripted"]),
        (["run", "--planner", "llm"], ["'llm'", "CALOT_LLM_URL", "CALOT_LLM_MODEL"]),
        (["run", "--instruct", "said.tsv"], ["--instruct", "said.tsv", "No such file"]),
        (["run", "--controller", "hand"], ["--controller", "'hand'", "expert", "idle"]),
        (["run", "--seed", "-1"], ["--seed", "'-1'", "whole number of at least 0"]),
        (["run", "--seed", "1.5"], ["--seed", "'1.5'", "whole number of at least 0"]),
        (["run", "--seed", "abc"], ["--seed", "'abc'", "whole number of at least 0"]),
        (["run", "--seed"], ["--seed"]),
        (["run", "--episodes", "0"], ["--episodes", "'0'", "whole number of at least 1"]),
        (["run", "--workers", "0"], ["--workers", "'0'", "whole number of at least 1"]),
        (["run", "--episodes", "1000000000000"], ["--episodes", "whole number of at most 100000"]),
        (["run", "--episodes", "9" * 5000], ["--episodes", "'999", "of at most 100000"]),
        (["evaluate", "--episodes", "1000000000"], ["--episodes", "of at most 100000"]),
        (["collect", "--out", "x", "--episodes", "1000000000"], ["--episodes", "at most 100000"]),
        (["run", "--workers", "1000000"], ["--workers", "'1000000'", "of at most 1024"]),
        (["train", "planner", "--threads", "99999999"], ["--threads", "of at most 1024"]),
        (["run", "--seed", "1" + 30 * "0"], ["--seed", "of at most 4294967295"]),
        (["train", "planner", "--steps", "1" + 30 * "0"], ["--steps", "of at most 1000000000"]),
        (["train", "planner", "--share", "nan"], ["share", "nan"]),
        (["evaluate", "--fail-under", "nan"], ["--fail-under", "nan"]),
        (["bench", "population", "--patients", "1" + 30 * "0"], ["--patients", "at most 100000"]),
        (["run", "--sed", "3"], ["--sed", "--seed"]),
        (["run", "--magnitude", "0.1"], ["--magnitude", "'nominal'", "breathing"]),
        (["run", "--scenario", "breathing", "--magnitude", "x"], ["--magnitude", "'x'", "number"]),
        (["run", "--scenario", "breathing", "--magnitude", "nan"], ["--magnitude", "0 to 0.02"]),
        (["run", "--scenario", "breathing", "--magnitude", "-1"], ["--magnitude", "0 to 0.02"]),
        (["run", "--scenario", "breathing", "--magnitude", "1"], ["--magnitude", "0 to 0.02"]),
        (["run", "--scenario", "latency", "--magnitude", "0.5"], ["--magnitude", "whole number"]),
        (["run", "--video", "view.avi"], ["--video", "view.avi", ".mp4"]),
        (["run", "--video", "view.mp4", "--episodes", "2"], ["--video", "--episodes 1", "2"]),
        (["view", "--port", "58080", "--say-port", "58080"], ["--port", "--say-port is the same"]),
        (["view", "--cameras", "ceiling"], ["--cameras", "ceiling", "wrist_left"]),
        (["view", "--host", "nowhere.invalid"], ["--host nowhere.invalid", "an address of this"]),
        (["view", "--port", "70000"], ["--port 70000", "no port is above 65535"]),
        ([*DIFFUSION, "--checkpoint", "."], ["--checkpoint", "it is a folder"]),
        ([*DIFFUSION, "--checkpoint", "none"], ["--checkpoint", "none", "there is no such file"]),
        (["run", "--checkpoint", "none"], ["--checkpoint", "'expert' takes none", "diffusion"]),
        (["run", "--view", "--workers", "2"], ["--view", "--workers 1", "got --workers 2"]),
        (["run", "--video", "v.mp4", "--cluster", "h:1"], ["--video", "got --cluster h:1"]),
        (["train", "controller", "--data"], ["--data: name a folder"]),
        (["evaluate", "--arms", "a=learned+diffusion,filter=on,filter=off"], ["given twice"]),
        (["run", "--overlay"], ["--overlay", "--video FILE.mp4"]),
        (["run", "--captions"], ["--captions", "--video FILE.mp4"]),
        (["train", "controller", "--steps", "0"], ["--steps", "'0'", "at least 1"]),
        (["train", "controller", "--steps", "-5"], ["--steps", "'-5'", "at least 1"]),
        (["train", "controller", "--leave-out", "zoo"], ["'zoo'", "nominal", "intervention"]),
        (
            ["train", "controller", "--leave-out", "intervention", "--data", "none"],
            ["none: there is no dataset"],
        ),
        (["evaluate", "--suite", "zoo"], ["--suite", "'zoo'", "nominal", "grasp-slip"]),
        (
            ["evaluate", "--suite", "registration", "--arms", "a=learned+diffusion,sense=exact"],
            ["--suite registration", "hand-eye", "exact", ",sense=tracked to the arm a"],
        ),
        (["operate"], ["operate", "run", "doctor"]),
        ([], ["run", "doctor"]),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing_behind(capfd, tmp_path, monkeypatch, words, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("CALOT_LLM_URL", raising=False)
    monkeypatch.delenv("CALOT_LLM_MODEL", raising=False)
    line = complaint(capfd, *words)
    assert all(word in line for word in said)
    assert list(tmp_path.iterdir()) == []


def test_every_planner_that_asks_an_endpoint_needs_one(monkeypatch):
    monkeypatch.delenv("CALOT_LLM_URL", raising=False)
    monkeypatch.setitem(PLANNERS, "rule", replace(PLANNERS["rule"], endpoint=True))
    with pytest.raises(BadInputError, match="CALOT_LLM_URL"):
        policy_options.require_policies("rule", "idle", None, None)


def test_a_folder_that_cannot_be_made_is_bad_input(capfd, tmp_path):
    (tmp_path / "file").touch()
    line = complaint(capfd, "run", "--out", str(tmp_path / "file" / "below"))
    assert "--out" in line
    assert str(tmp_path / "file" / "below") in line


def test_a_file_in_place_of_the_folder_is_bad_input_and_stays(capfd, tmp_path):
    (tmp_path / "file").write_text("kept")
    assert "--out" in complaint(capfd, "run", "--out", str(tmp_path / "file"))
    assert (tmp_path / "file").read_text() == "kept"


def test_checking_whether_a_folder_can_be_written_to_leaves_none_behind(tmp_path):
    for folder in ("new/folder", "new/../folder", "new/below/../../folder/.."):
        require_writable_folder(tmp_path / folder, "--out")
        assert list(tmp_path.iterdir()) == []


def test_a_folder_that_somebody_else_begins_to_use_meanwhile_stays(tmp_path, monkeypatch):
    used = tmp_path / "new"

    def temporary_file(dir):
        (used / "file").touch()
        return BytesIO()

    monkeypatch.setattr(tempfile, "TemporaryFile", temporary_file)
    require_writable_folder(used, "--out")
    assert [path.name for path in used.iterdir()] == ["file"]


def test_folders_made_on_the_way_to_a_failure_are_removed(capfd, tmp_path):
    impossible = tmp_path / "new" / ("x" * 300)
    complaint(capfd, "run", "--out", str(impossible))
    assert list(tmp_path.iterdir()) == []


def test_video_without_a_renderer_is_bad_input(capfd, tmp_path, monkeypatch):
    from tissue_sim.rendering.renderer import renderer_kind

    for variable in ("VK_DRIVER_FILES", "VK_ICD_FILENAMES"):
        monkeypatch.setenv(variable, str(tmp_path / "no-driver.json"))
    renderer_kind.cache_clear()
    try:
        line = complaint(
            capfd, "run", "--video", str(tmp_path / "v.mp4"), "--out", str(tmp_path / "out")
        )
    finally:
        renderer_kind.cache_clear()
    assert "renderer" in line
    assert "calot doctor" in line
    assert list(tmp_path.iterdir()) == []


def test_words_become_the_command_they_name():
    assert parse(["run", "--seed", "7", "--controller", "idle"]) == Run(seed=7, controller="idle")


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_is_reached_from_the_command_line(name):
    command = parse(["run", "--scenario", name])
    assert isinstance(command, Run)
    config = EpisodeConfig(scenario=command.scenario, sense=SENSE_OF.get(name, "tracked"))
    assert config.perturbations == SCENARIOS[name].perturbations


def test_a_magnitude_replaces_the_scenarios_own():
    words = ["run", "--scenario", "breathing", "--magnitude", "0.004"]
    assert parse(words) == Run(scenario="breathing", magnitude=0.004)
    (breathing,) = EpisodeConfig(**ORACLE, scenario="breathing", magnitude=0.004).perturbations
    assert breathing.magnitude == 0.004


@pytest.mark.parametrize("words", [["--help"], ["run", "--help"]])
def test_help_is_no_error(capsys, words):
    with pytest.raises(SystemExit) as stop:
        main(words)
    assert stop.value.code in (0, None)
    assert "calot" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"scenario": "zoo"}, "unknown scenario 'zoo'; allowed: nominal"),
        (
            {"planner": "oracle"},
            "unknown planner 'oracle'; allowed: learned, learned-alone, llm, rule, scripted",
        ),
        (
            {"controller": "hand"},
            "unknown controller 'hand'; allowed: diffusion, diffusion-alone, idle, expert",
        ),
        ({"seed": -1}, "seed must be a whole number of at least 0, got -1"),
        ({"seed": 1.0}, "seed must be a whole number of at least 0, got 1.0"),
    ],
)
def test_the_library_refuses_the_same(wrong, said):
    with pytest.raises(ValueError, match=said):
        EpisodeConfig(**ORACLE | wrong)


@pytest.mark.parametrize(
    ("episodes", "code"),
    [
        ([PASSED], 0),
        ([PASSED, CALLED], 0),
        ([CALLED], 0),
        ([PASSED, NEEDLESS], 1),
        ([PASSED, FAILED], 1),
        ([FAILED, CALLED], 1),
        ([CALLED, ERROR], 3),
        ([PASSED, ERROR], 3),
        ([PASSED, FAILED, ERROR], 3),
    ],
)
def test_the_exit_code_tells_failures_from_errors(episodes, code):
    assert exit_code(episodes) == code


def test_a_usage_error_is_one_line_without_a_title_where_the_terminal_has_ascii_only():
    program = "import sys; from scenarios.cli import main; sys.exit(main(['run', '--seed', '-1']))"
    found = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, env=os.environ | {"PYTHONIOENCODING": "latin-1"},
    )  # fmt: skip
    assert found.stderr.startswith("calot: Error parsing --seed: '-1'")
    assert found.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("source", "told"),
    [
        ("def make(setup", "SyntaxError: '(' was never closed"),
        ("raise RuntimeError('no licence')", "RuntimeError: no licence (mine.py:1)"),
        ("import no_such_module", "No module named 'no_such_module'"),
    ],
)
def test_a_policy_that_cannot_be_imported_is_told_in_one_line(
    capfd, tmp_path, monkeypatch, source, told
):
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "mine", raising=False)
    (tmp_path / "mine.py").write_text(source)
    said = complaint(capfd, "run", "--controller", "mine:make", "--out", str(tmp_path / "out"))
    assert said.startswith(f"calot: --controller mine:make: {told}")


def test_a_folder_of_the_one_command_is_no_folder_of_the_other(capfd, tmp_path):
    (tmp_path / "results.json").write_text("{}")
    words = ("--out", str(tmp_path), "--episodes", "1")
    assert "has results of `calot run`" in complaint(capfd, "evaluate", *words)
    (tmp_path / "evaluation.json").write_text("{}")
    assert "has a report of `calot evaluate`" in complaint(capfd, "run", *words)
    assert (tmp_path / "results.json").read_text() == "{}"


def test_nothing_heavy_is_imported_before_help_is_given():
    program = f"import sys, scenarios.cli; print([m for m in {HEAVY} if m in sys.modules])"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert found.stdout.strip() == "[]", found.stderr


def test_an_episode_without_a_learned_policy_needs_no_torch():
    """Importing torch takes longer than all the rest of Calot."""
    program = "import sys, scenarios.run_episode, controller.expert.controller, planner.scripted;"
    program += " print('torch' in sys.modules)"
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert found.stdout.strip() == "False", found.stderr
