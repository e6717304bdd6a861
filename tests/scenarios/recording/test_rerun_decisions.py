"""Tests of a repeated episode: policies decide again, with the same result bit for bit.

What people did is repeated from the recording; any other change is found or refused.
"""

from dataclasses import replace

import numpy as np
import pytest

from controller.diffusion.policy import CHECKPOINTS, Policy
from controller.diffusion.training import PRESETS
from scenarios.catalogue import CONTROLLERS, ORACLE, PEOPLE, PolicyEntry
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.recording.attempt import attempt_episode
from scenarios.recording.first_difference import FirstDifference, first_difference
from scenarios.recording.recorder import load
from scenarios.recording.rerun_decisions import repeat
from scenarios.recording.schema import STEP_ARRAYS
from tests.scenarios.interfered import record

SEED = 10_000
IDLE = EpisodeConfig(
    planner="scripted", scenario="textbook", seed=SEED, controller="idle", task_cap_s=1.0
)


def attempted(config, out):
    attempt_episode(config, out)
    return load(out / "episodes" / f"{config.seed}.npz")


@pytest.fixture(scope="module")
def idle(tmp_path_factory):
    return attempted(IDLE, tmp_path_factory.mktemp("idle"))


@pytest.mark.slow
def test_a_whole_procedure_comes_out_the_same(procedure, tmp_path):
    assert procedure.recording.result is not None
    assert first_difference(procedure.recording, repeat(procedure.recording, tmp_path)) is None


@pytest.fixture(scope="module")
def interfered(tmp_path_factory):
    path = tmp_path_factory.mktemp("interfered") / "live.npz"
    return record(path, EpisodeConfig(**ORACLE, seed=SEED, scenario="breathing"))[0]


def test_all_that_people_did_is_repeated(interfered, tmp_path):
    assert {entry["by"] for entry in interfered.heard} > {"button"}
    assert len(interfered.hands) == 10
    assert first_difference(interfered, repeat(interfered, tmp_path)) is None


@pytest.mark.parametrize("name", ["heard", "hands"])
def test_without_the_actions_of_people_it_ends_differently(interfered, name, tmp_path):
    step = getattr(interfered, name)[0]["step"]
    arrays = {key: array[: step + 10] for key, array in interfered.arrays.items()}
    without = replace(interfered, arrays=arrays, **{name: ()})
    found = first_difference(without, repeat(without, tmp_path))
    assert found is not None
    assert found.step == step


def test_instructions_from_a_file_are_repeated_without_the_file(tmp_path):
    script = tmp_path / "said.tsv"
    script.write_text("0.3\tmove right arm higher\n0.6\tthe weather is nice\n")
    recording = attempted(replace(IDLE, instruct=str(script)), tmp_path)
    script.unlink()
    assert [entry["text"] for entry in recording.heard] == [
        "move right arm higher",
        "the weather is nice",
    ]
    assert first_difference(recording, repeat(recording, tmp_path / "again")) is None


class Talker:
    """A scripted person: says one thing after some steps."""

    def __init__(self, inbox):
        self._inbox, self._steps = inbox, 0

    def on_reset(self, world):
        del world

    def on_step(self, step):
        del step
        self._steps += 1
        if self._steps == 10:
            self._inbox.say("move right arm higher")

    def on_end(self, result):
        del result


def test_a_scripted_person_is_repeated_from_the_recording_and_does_not_speak_twice(
    monkeypatch, tmp_path
):
    monkeypatch.setitem(PEOPLE, "talker", f"{__name__}:Talker")
    recording = attempted(replace(IDLE, person="talker"), tmp_path)
    assert [entry["step"] for entry in recording.heard] == [10]
    again = repeat(recording, tmp_path / "again")
    assert first_difference(recording, again) is None
    assert len(again.heard) == 1


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """Return an episode of a diffusion policy with its initial weights, and the checkpoint."""
    out = tmp_path_factory.mktemp("learned")
    checkpoint = out / "policy.safetensors"
    CHECKPOINTS.save(checkpoint, Policy(PRESETS["smoke"].policy))
    config = replace(IDLE, controller="diffusion", checkpoint=str(checkpoint))
    return attempted(config, out), checkpoint


def test_a_learned_controllers_noise_comes_again(learned, tmp_path):
    recording, _ = learned
    assert np.ptp(recording.arrays["commands"], axis=0).any()
    assert first_difference(recording, repeat(recording, tmp_path)) is None


def test_another_checkpoint_under_the_same_name_is_refused(learned, tmp_path):
    recording, checkpoint = learned
    other = tmp_path / "policy.safetensors"
    CHECKPOINTS.save(other, Policy(PRESETS["smoke"].policy))
    config = {**recording.config, "checkpoint": str(other)}
    with pytest.raises(ValueError, match="controller's checkpoint is another file now"):
        repeat(replace(recording, config=config), tmp_path)
    config["checkpoint"] = str(tmp_path / "gone.safetensors")
    with pytest.raises(ValueError, match="cannot be read"):
        repeat(replace(recording, config=config), tmp_path)
    assert checkpoint.exists()


def test_an_error_comes_again_and_its_absence_is_noticed(tmp_path, monkeypatch):
    with monkeypatch.context() as patch:
        breaks = "tests.scenarios.breaking_controller:ControllerBreaks"
        patch.setitem(CONTROLLERS, "breaks", PolicyEntry(factory=breaks))
        recording = attempted(replace(IDLE, controller="breaks"), tmp_path)
        assert recording.error == "RuntimeError: a string snapped"
        assert first_difference(recording, repeat(recording, tmp_path / "again")) is None
        patch.setitem(CONTROLLERS, "breaks", CONTROLLERS["idle"])
        found = first_difference(recording, repeat(recording, tmp_path / "mended"))
    assert found == FirstDifference(step=len(recording.arrays["time_s"]), field="error")


def test_an_interrupted_episode_is_repeated_as_far_as_it_was_recorded(idle, tmp_path):
    cut = replace(
        idle,
        arrays={name: array[:20] for name, array in idle.arrays.items()},
        result=None,
        error="KeyboardInterrupt",
    )
    assert first_difference(cut, repeat(cut, tmp_path)) is None


def test_another_world_is_refused(idle, tmp_path):
    with pytest.raises(ValueError, match="made in world version 999, but here it is"):
        repeat(replace(idle, world_version=999), tmp_path)


def test_an_endpoint_that_is_not_named_is_refused(idle, tmp_path, monkeypatch):
    monkeypatch.delenv("CALOT_LLM_URL", raising=False)
    with pytest.raises(ValueError, match="CALOT_LLM_URL"):
        repeat(replace(idle, config={**idle.config, "planner": "llm"}), tmp_path)


@pytest.mark.parametrize("name", [name for name in STEP_ARRAYS if name != "instruction"])
def test_a_change_of_any_recorded_number_is_found_at_its_step(idle, name):
    arrays = {key: array.copy() for key, array in idle.arrays.items()}
    arrays[name].reshape(len(arrays[name]), -1)[7:, -1] += 2
    found = first_difference(idle, replace(idle, arrays=arrays))
    assert found == FirstDifference(step=7, field=name, size=2.0)


def test_equality_is_of_the_bits(idle):
    arrays = {name: array.copy() for name, array in idle.arrays.items()}
    arrays["forces_n"][3, 0, 0] = np.nan
    strange = replace(idle, arrays=arrays)
    assert first_difference(strange, strange) is None
    arrays = {name: array.copy() for name, array in idle.arrays.items()}
    arrays["forces_n"][:] = 0.0
    zero = replace(idle, arrays=arrays)
    below = {**arrays, "forces_n": -arrays["forces_n"]}
    found = first_difference(zero, replace(zero, arrays=below))
    assert found == FirstDifference(step=0, field="forces_n", size=0.0)


@pytest.mark.parametrize(
    ("change", "step", "field"),
    [
        ({"events": ({"step": 4, "event": "leak"},)}, 4, "events"),
        ({"ledger": ({"step": 9, "limits": ["speed"]},)}, 9, "ledger"),
        ({"anatomy": {"seed": 3}}, 0, "anatomy"),
        ({"error": "OSError"}, 31, "error"),
        ({"result": {}}, 31, "result, scenario"),
    ],
)
def test_a_change_of_a_logged_event_is_found(idle, change, step, field):
    assert len(idle.arrays["time_s"]) == 31
    assert first_difference(idle, replace(idle, **change)) == FirstDifference(
        step=step, field=field
    )
    assert first_difference(replace(idle, **change), idle) == FirstDifference(
        step=step, field=field
    )


def test_another_instruction_is_found_where_it_was_first_given(idle):
    rows = idle.arrays["instruction"].copy()
    rows[11:] = 1
    arrays = {**idle.arrays, "instruction": rows}
    table = (*idle.instructions, {**idle.instructions[0], "text": "go home"})
    found = first_difference(idle, replace(idle, arrays=arrays, instructions=table))
    assert found == FirstDifference(step=11, field="instruction")


def test_an_episode_that_ends_early_is_found(idle):
    short = {name: array[:-5] for name, array in idle.arrays.items()}
    found = first_difference(idle, replace(idle, arrays=short))
    assert found == FirstDifference(step=26, field="number of steps", size=5)
