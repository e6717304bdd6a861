"""Record an episode in one file: instructions, commands, poses and forces of each step."""

import io
import json
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from zipfile import BadZipFile, is_zipfile

import numpy as np

from controller.safety.ledger import Ledger
from planner.learning.atomic_write import write_atomic
from scenarios.files.errors import describe_error
from scenarios.files.strict_json import dumps, plain
from scenarios.files.versions import versions
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult
from scenarios.recording.checkpoint_digests import checkpoint_digests
from scenarios.workers.stop_signals import saving
from tissue_sim.version import WORLD_VERSION

SCHEMA_VERSION = 7
RIGHT_TOOLS = ("clip_applier", "scissors")

STEP_ARRAYS: dict[str, tuple[int, ...]] = {
    "time_s": (),
    "commands": (2, 7),
    "joints": (2, 7),
    "tips_endoscope": (2, 4, 4),
    "forces_n": (2, 3),
    "instruction": (),
    "right_tool": (),
    "clip_loaded": (),
}
"""Shape of each recorded quantity in one step; the file stacks the steps along a first axis."""

NOTES = ("events", "perturbations", "ledger", "heard", "told", "hands")
"""What is recorded only for some steps; each entry has its `step`."""

_WHOLE = ("instruction", "right_tool", "clip_loaded")


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A recorded episode.

    Attributes:
        config: the `EpisodeConfig`, as a dict.
        versions: of the packages that it was made with.
        world_version: version of the physics.
        checkpoints: SHA-256 of each checkpoint, by `controller`, `planner` and `perception`.
        anatomy: the anatomy, as a dict; None if the episode broke off before its reset.
        instructions: table of instructions: task index, text, source, remark.
        events: injuries, in order, each with its step.
        perturbations: applied perturbations, in order, each with the step of its onset.
        ledger: the safety filter's changes, in order, each with the step in which it began.
        heard: what people said, in order, each with its step: how and by what it was read, the
            resulting instruction, and the reply; commands and instructions by their texts.
        told: what the robot said by itself, how orders ended, each with its step.
        hands: each `GuidedArm`, with its step.
        result: the `EpisodeResult`, as a dict; None if the episode broke off.
        error: the error that broke it off; None for none.
        arrays: by the names of `STEP_ARRAYS`; joints in rad and m, left arm first, tip poses in
            the endoscope frame (m), forces in N; `instruction` is a row of `instructions`,
            `right_tool` one of `RIGHT_TOOLS`, `clip_loaded` 0 or 1.
    """

    config: dict[str, Any]
    versions: dict[str, str]
    world_version: int
    checkpoints: dict[str, str]
    anatomy: dict[str, Any] | None
    instructions: tuple[dict[str, Any], ...]
    events: tuple[dict[str, Any], ...]
    perturbations: tuple[dict[str, Any], ...]
    ledger: tuple[dict[str, Any], ...]
    heard: tuple[dict[str, Any], ...]
    told: tuple[dict[str, Any], ...]
    hands: tuple[dict[str, Any], ...]
    result: dict[str, Any] | None
    error: str | None
    arrays: dict[str, np.ndarray]


@dataclass(kw_only=True)
class Recorder:
    """Observes an episode in a `with` block, and saves it when the block is left.

    It also saves after an exception or a signal, and no signal cuts the saving short.
    """

    config: EpisodeConfig
    path: Path
    _anatomy: Any = None
    _result: EpisodeResult | None = None
    _instructions: dict[tuple[int, str, str, str], int] = field(default_factory=dict)
    _events: list[dict[str, Any]] = field(default_factory=list)
    _perturbations: list[dict[str, Any]] = field(default_factory=list)
    _ledger: Ledger = field(default_factory=Ledger)
    _ledger_steps: list[int] = field(default_factory=list)  # in which each entry began
    _heard: list[dict[str, Any]] = field(default_factory=list)
    _told: list[dict[str, Any]] = field(default_factory=list)
    _hands: list[dict[str, Any]] = field(default_factory=list)
    _checkpoints: dict[str, str] = field(default_factory=dict)
    _steps: dict[str, list[Any]] = field(default_factory=lambda: {name: [] for name in STEP_ARRAYS})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        with saving():
            self._save(None if error is None else describe_error(error))

    def on_reset(self, world: Any) -> None:
        """Record the anatomy and the checkpoints."""
        self._anatomy = plain(world.anatomy)
        self._checkpoints = checkpoint_digests(self.config)

    def on_step(self, step: Any) -> None:
        """Record one step."""
        number = len(self._steps["time_s"])
        quantities = {
            "time_s": step.time_s,
            "commands": step.command.joints,
            "joints": step.exact.joints,
            "tips_endoscope": step.exact.tips_endoscope,
            "forces_n": step.exact.forces_n,
            "instruction": self._row(step.instruction),
            "right_tool": RIGHT_TOOLS.index(step.exact.tools[1]),
            "clip_loaded": step.exact.clip_loaded,
        }
        checked = {name: _checked(name, quantity) for name, quantity in quantities.items()}
        for name, array in checked.items():
            self._steps[name].append(array)
        for event in step.outcome.events:
            self._events.append({"step": number, **plain(event)})
        for applied in step.applied:
            self._perturbations.append({"step": number, **plain(applied)})
        for entry in step.altered:
            if self._ledger.note(entry) == len(self._ledger_steps):
                self._ledger_steps.append(number)
        for heard in step.heard:
            self._heard.append({"step": number, **_in_words(heard)})
        self._told += [{"step": number, "text": text} for text in step.told]
        if step.guided is not None:
            self._hands.append({"step": number, **plain(step.guided)})

    def on_end(self, result: EpisodeResult) -> None:
        """Record the result."""
        self._result = result

    def _row(self, instruction: Any) -> int:
        key = (instruction.task.index, instruction.text, instruction.source, instruction.remark)
        return self._instructions.setdefault(key, len(self._instructions))

    def _save(self, error: str | None) -> None:
        header = {
            "schema_version": SCHEMA_VERSION,
            "config": self.config,
            "versions": versions(),
            "world_version": WORLD_VERSION,
            "checkpoints": self._checkpoints,
            "anatomy": self._anatomy,
            "instructions": [
                {"task": task, "text": text, "source": source, "remark": remark}
                for task, text, source, remark in self._instructions
            ],
            "events": self._events,
            "perturbations": self._perturbations,
            "ledger": [
                {"step": step, **plain(entry)}
                for step, entry in zip(self._ledger_steps, self._ledger.entries, strict=True)
            ],
            "heard": self._heard,
            "told": self._told,
            "hands": self._hands,
            "result": self._result,
            "error": error,
        }
        arrays = {
            name: np.array(values, dtype=_dtype(name)).reshape(-1, *STEP_ARRAYS[name])
            for name, values in self._steps.items()
        }
        buffer = io.BytesIO()
        np.savez_compressed(buffer, allow_pickle=False, header=np.array(dumps(header)), **arrays)
        write_atomic(self.path, buffer.getvalue())


def _in_words(heard: Any) -> dict[str, Any]:
    """Return a `Heard` as plain data."""
    reading, instruction = heard.reading, heard.instruction
    return {
        "time_s": heard.time_s,
        "text": heard.text,
        "command": reading.command.text if reading.command else None,
        "then": [said.command.text for said in reading.then],
        "guesses": [guess.text for guess in reading.guesses],
        "confidence": reading.confidence,
        "by": reading.by,
        "instruction": instruction.text if instruction else None,
        "reply": heard.reply,
    }


def _dtype(name: str) -> type[np.generic]:
    return np.int64 if name in _WHOLE else np.float64


def _checked(name: str, quantity: Any) -> np.ndarray:
    array = np.array(quantity, dtype=_dtype(name))
    if array.shape != STEP_ARRAYS[name]:
        raise ValueError(f"a step's {name} must have shape {STEP_ARRAYS[name]}, got {array.shape}")
    return array


def load(path: Path, *, steps: bool = True) -> Recording:
    """Read a recorded episode; without `steps`, quickly and without its arrays.

    Raises:
        ValueError: the file has another schema, is damaged, or is not a recording.
        OSError: the file cannot be read.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            header = json.loads(str(file["header"]))
            arrays = {name: file[name] for name in file if name != "header"} if steps else {}
        schema_version = header["schema_version"]
    except (BadZipFile, zlib.error, EOFError, KeyError, TypeError, ValueError) as error:
        why = error if is_zipfile(path) else "it is no .npz file"
        raise ValueError(f"{path} is damaged, or no recording: {why}") from error
    if schema_version != SCHEMA_VERSION:
        raise ValueError(f"{path} has schema {schema_version}; allowed: {SCHEMA_VERSION}")
    return Recording(
        config=header["config"],
        versions=header["versions"],
        world_version=header["world_version"],
        checkpoints=header["checkpoints"],
        anatomy=header["anatomy"],
        instructions=tuple(header["instructions"]),
        events=tuple(header["events"]),
        perturbations=tuple(header["perturbations"]),
        ledger=tuple(header["ledger"]),
        heard=tuple(header["heard"]),
        told=tuple(header["told"]),
        hands=tuple(header["hands"]),
        result=header["result"],
        error=header["error"],
        arrays=arrays,
    )
