"""Tests of the recorder: all steps are read back bit for bit, after any end of the episode."""

import json
from dataclasses import replace

import numpy as np
import pytest

from controller.safety.ledger import Entry
from planner.instruction import CORRECTIONS, TASKS, Instruction
from scenarios.catalogue import ORACLE
from scenarios.files.strict_json import plain
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.person.inbox import Heard, Inbox
from scenarios.loop.results import EpisodeResult, TaskResult
from scenarios.perturbation.effect import Applied
from scenarios.recording.recorder import Recorder, load
from scenarios.recording.rerun_commands import config_of
from scenarios.recording.schema import SCHEMA_VERSION, STEP_ARRAYS
from tests.scenarios.recording.made_up_step import random_step
from tests.worlds import textbook_world
from tissue_sim.surgery.injury import Injury

WORLD = textbook_world(10_003)
CONFIG = EpisodeConfig(**ORACLE, scenario="textbook", seed=20_007)
DONE = TaskResult(index=1, instruction="grab", success=True, time_s=0.0, corrections=0)
RESULT = EpisodeResult(**ORACLE, scenario="textbook", seed=20_007, success=True, tasks=(DONE,))


def record(path, steps, result=None):
    with Recorder(config=CONFIG, path=path) as recorder:
        recorder.on_reset(WORLD)
        for step in steps:
            recorder.on_step(step)
        if result is not None:
            recorder.on_end(result)


def test_every_step_is_read_back_bit_for_bit(tmp_path):
    rng = np.random.default_rng(0)
    steps = [random_step(rng, number) for number in range(5)]
    record(tmp_path / "episode.npz", steps)
    arrays = load(tmp_path / "episode.npz").arrays
    for number, step in enumerate(steps):
        assert arrays["time_s"][number] == step.time_s
        np.testing.assert_array_equal(arrays["commands"][number], step.command.joints)
        for name in ("joints", "tips_endoscope", "forces_n"):
            np.testing.assert_array_equal(arrays[name][number], getattr(step.exact, name))


def test_later_changes_of_an_array_do_not_reach_the_record(tmp_path):
    step = random_step(np.random.default_rng(0), 0)
    kept = step.command.joints.copy()
    with Recorder(config=CONFIG, path=tmp_path / "episode.npz") as recorder:
        recorder.on_step(step)
        step.command.joints.base[:] = 0.0  # as its owner may
    np.testing.assert_array_equal(load(tmp_path / "episode.npz").arrays["commands"][0], kept)


def test_the_words_at_each_step_are_found_in_the_table(tmp_path):
    rng = np.random.default_rng(0)
    given = [
        Instruction(task=TASKS[0]),
        Instruction(task=TASKS[1]),
        Instruction(task=TASKS[1], correction=CORRECTIONS[3], source="human"),
        Instruction(task=TASKS[1]),
        Instruction(task=TASKS[2], correction=CORRECTIONS[3]),
    ]
    record(tmp_path / "episode.npz", [random_step(rng, k, one) for k, one in enumerate(given)])
    recording = load(tmp_path / "episode.npz")
    rows = [recording.instructions[row] for row in recording.arrays["instruction"]]
    assert [(row["task"], row["text"], row["source"]) for row in rows] == [
        (one.task.index, one.text, one.source) for one in given
    ]
    assert len(recording.instructions) == 4


def test_events_keep_the_step_they_happened_at(tmp_path):
    rng = np.random.default_rng(0)
    leak = Injury(event="leak", time_s=0.1, value=1e-9, limit=0.0)
    steps = [random_step(rng, 0), random_step(rng, 1, events=(leak,))]
    record(tmp_path / "episode.npz", steps)
    assert load(tmp_path / "episode.npz").events == ({"step": 1, **plain(leak)},)


def test_a_finished_episode_carries_its_anatomy_config_and_result(tmp_path):
    record(tmp_path / "episode.npz", [], RESULT)
    recording = load(tmp_path / "episode.npz")
    assert config_of(recording) == CONFIG
    assert recording.anatomy == plain(WORLD.anatomy)
    assert recording.result is not None
    assert recording.result["success"] is True
    assert recording.error is None
    assert "python" in recording.versions


@pytest.mark.parametrize("blow", [RuntimeError("solver diverged"), KeyboardInterrupt()])
def test_a_broken_off_episode_keeps_the_steps_it_had(tmp_path, blow):
    rng = np.random.default_rng(0)

    def episode():
        with Recorder(config=CONFIG, path=tmp_path / "episode.npz") as recorder:
            recorder.on_step(random_step(rng, 0))
            raise blow

    with pytest.raises(type(blow)):
        episode()
    recording = load(tmp_path / "episode.npz")
    assert len(recording.arrays["time_s"]) == 1
    assert recording.result is None
    assert recording.error is not None
    assert recording.error.startswith(type(blow).__name__)


def test_an_episode_without_steps_keeps_its_shapes(tmp_path):
    record(tmp_path / "episode.npz", [])
    arrays = load(tmp_path / "episode.npz").arrays
    assert {name: array.shape for name, array in arrays.items()} == {
        name: (0, *shape) for name, shape in STEP_ARRAYS.items()
    }


def test_a_step_of_the_wrong_shape_is_refused_and_the_others_are_kept(tmp_path):
    rng = np.random.default_rng(0)
    path = tmp_path / "episode.npz"
    wrong = random_step(rng, 1)
    wrong = replace(wrong, exact=replace(wrong.exact, forces_n=np.zeros((3, 2))))
    with pytest.raises(ValueError, match=r"forces_n must have shape \(2, 3\), got \(3, 2\)"):
        record(path, [random_step(rng, 0), wrong])
    assert {len(array) for array in load(path).arrays.values()} == {1}


def test_another_schema_is_refused(tmp_path):
    path = tmp_path / "episode.npz"
    np.savez_compressed(path, header=np.array(json.dumps({"schema_version": 999})))
    with pytest.raises(ValueError, match=f"has schema 999; allowed: {SCHEMA_VERSION}"):
        load(path)


def test_perturbations_are_kept_with_their_step(tmp_path):
    told = Applied(name="breathing", time_s=0.1, magnitude=0.002, unit="m of amplitude")
    rng = np.random.default_rng(3)
    steps = [random_step(rng, k, applied=(told,) if k == 3 else ()) for k in range(5)]
    record(tmp_path / "e.npz", steps)
    (kept,) = load(tmp_path / "e.npz").perturbations
    assert kept == {"step": 3, **plain(told)}


def test_altered_commands_are_kept_with_their_step(tmp_path):
    entry = Entry(time_s=0.1, limits=("keep-out: right shaft to liver",), margin=0.002)
    steps = [
        random_step(np.random.default_rng(0), k, altered=(entry,) * (k == 1)) for k in range(3)
    ]
    record(tmp_path / "e.npz", steps)
    assert load(tmp_path / "e.npz").ledger == ({"step": 1, **plain(entry)},)


def test_every_utterance_is_kept_with_its_reading_and_its_answer(tmp_path):
    inbox, said = Inbox(), ("move right arm higher", "the weather\x00 ü世 is nice \ud800", "")
    for text in said:
        inbox.say(text)
    obeyed = Instruction(task=TASKS[0], correction=CORRECTIONS[8], source="human")
    heard = tuple(
        Heard(
            time_s=0.5, reading=r, instruction=obeyed if r.command else None, reply=f"re: {r.text}"
        )
        for r in inbox.take(0.5)
    )
    rng = np.random.default_rng(0)
    steps = [random_step(rng, k, heard=heard if k == 2 else ()) for k in range(4)]
    record(tmp_path / "e.npz", steps)
    kept = load(tmp_path / "e.npz").heard
    shown = [text.replace("\ud800", "?") for text in said]  # half a letter
    assert [(line["step"], line["time_s"], line["text"]) for line in kept] == [
        (2, 0.5, text) for text in shown
    ]
    assert [line["command"] for line in kept] == ["move right arm higher", None, None]
    assert [line["instruction"] for line in kept] == [obeyed.text, None, None]
    assert [line["reply"] for line in kept] == [f"re: {text}" for text in shown]


def test_what_the_robot_says_by_itself_is_kept_with_its_step(tmp_path):
    rng = np.random.default_rng(0)
    said = ("Done: grabbing gallbladder. I go on.",)
    record(tmp_path / "e.npz", [random_step(rng, k, told=said * (k == 2)) for k in range(4)])
    assert load(tmp_path / "e.npz").told == ({"step": 2, "text": said[0]},)
