"""Record an episode in one file: instructions, commands, poses and forces of each step."""

import io
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self
from zipfile import is_zipfile

import numpy as np

from controller.safety.ledger import Ledger
from planner.learning.files import content_hash, from_json, read_npz, write_atomic
from scenarios.files.errors import describe_error
from scenarios.files.strict_json import dumps, plain
from scenarios.files.versions import versions
from scenarios.loop.episode_config import EpisodeConfig, checkpoint_digests
from scenarios.loop.results import EpisodeResult
from scenarios.recording.schema import (
    MAX_BYTES,
    NOTES,
    PARTS,
    SCHEMA_VERSION,
    STEP_ARRAYS,
    WHOLE,
    require_agreement,
    require_header,
    require_steps,
)
from scenarios.workers.process import saving
from tissue_sim.constants import WORLD_VERSION
from tissue_sim.tools.instruments import right_tools

HEADER, HASH = "header", "sha256"  # in the file, besides the arrays of the steps


@dataclass(frozen=True, kw_only=True)
class Recording:
    """A recorded episode.

    Attributes:
        config: The `EpisodeConfig`, as a dict.
        versions: Versions of the packages that made the recording.
        world_version: Version of the physics.
        checkpoints: SHA-256 of each checkpoint, by `controller`, `planner` and `perception`.
        anatomy: The anatomy, as a dict; None if the episode broke off before its reset.
        instructions: Table of instructions: task index, text, source, remark, right tool.
        events: Injuries, in order, each with its step.
        perturbations: Applied perturbations, in order, each with the step of its onset.
        ledger: The safety filter's changes, in order, each with the step in which it began.
        heard: People's words, in order, each with its step: the reading and its reader, the
            resulting instruction, and the reply. Commands and instructions are stored by their
            texts.
        told: The robot's reports of how orders ended, each with its step.
        hands: Each `GuidedArm`, with its step.
        result: The `EpisodeResult`, as a dict; None if the episode broke off.
        error: The error that broke the episode off; None for none.
        sha256: Hash of the whole content; None before schema 8.
        arrays: Arrays by the names of `STEP_ARRAYS`. Joints are in rad and m, left arm first; tip
            poses are in the endoscope frame (m); forces are in N. `instruction` is a row of
            `instructions`, `right_tool` one of `right_tools()`, `clip_loaded` 0 or 1.
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
    sha256: str | None
    arrays: dict[str, np.ndarray]


@dataclass(kw_only=True)
class Recorder:
    """Observes an episode in a `with` block, and saves it when the block is left.

    The recorder also saves after an exception or a signal, and no signal cuts the saving short.
    `is_saved` tells whether its file was written, even if the file was moved since.
    """

    config: EpisodeConfig
    path: Path
    is_saved: bool = False
    _anatomy: Any = None
    _result: EpisodeResult | None = None
    _instructions: dict[tuple[int, str, str, str, str], int] = field(default_factory=dict)
    _notes: dict[str, list[dict[str, Any]]] = field(
        default_factory=lambda: {name: [] for name in NOTES}
    )
    _ledger: Ledger = field(default_factory=Ledger)
    _ledger_steps: list[int] = field(default_factory=list)  # in which each entry began
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
            "commands": step.command.joints,
            "instruction": self._row(step.instruction),
            **recomputed(step.exact),
            "time_s": step.time_s,
        }
        checked = {name: _checked(name, quantity) for name, quantity in quantities.items()}
        for name, array in checked.items():
            self._steps[name].append(array)
        for entry in step.altered:
            if self._ledger.note(entry) == len(self._ledger_steps):
                self._ledger_steps.append(number)
        noted = {
            "events": step.outcome.events,
            "perturbations": step.applied,
            "heard": map(_in_words, step.heard),
            "told": ({"text": text} for text in step.told),
            "hands": filter(None, [step.guided]),
        }
        for name, entries in noted.items():
            self._notes[name] += [{"step": number, **plain(entry)} for entry in entries]

    def on_end(self, result: EpisodeResult) -> None:
        """Record the result."""
        self._result = result

    def _row(self, instruction: Any) -> int:
        said = instruction
        key = (said.task.index, said.text, said.source, said.remark, said.tool)
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
                {"task": task, "text": text, "source": source, "remark": remark, "tool": tool}
                for task, text, source, remark, tool in self._instructions
            ],
            **self._notes,
            "ledger": [
                {"step": step, **plain(entry)}
                for step, entry in zip(self._ledger_steps, self._ledger.entries, strict=True)
            ],
            "result": self._result,
            "error": error,
        }
        arrays = {
            name: np.array(values, dtype=_dtype(name)).reshape(-1, *STEP_ARRAYS[name])
            for name, values in self._steps.items()
        }
        write_atomic(self.path, recording_bytes(header, arrays))
        self.is_saved = True


def recording_bytes(header: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return the content of a recording's file, with its hash."""
    content = {**arrays, HEADER: np.array(dumps(header))}
    digest = np.array(content_hash(content))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, allow_pickle=False, **content, **{HASH: digest})
    return buffer.getvalue()


def recomputed(exact: Any) -> dict[str, np.ndarray]:
    """Return the quantities that follow from the commands alone, of the world's exact state."""
    quantities = {
        "time_s": exact.time_s,
        "joints": exact.joints,
        "tips_endoscope": exact.tips_endoscope,
        "forces_n": exact.forces_n,
        "right_tool": right_tools().index(exact.tools[1]),
        "clip_loaded": exact.clip_loaded,
    }
    return {name: np.array(value, dtype=_dtype(name)) for name, value in quantities.items()}


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
    return np.int64 if name in WHOLE else np.float64


def _checked(name: str, quantity: Any) -> np.ndarray:
    array = np.array(quantity, dtype=_dtype(name))
    if array.shape != STEP_ARRAYS[name]:
        raise ValueError(f"a step's {name} must have shape {STEP_ARRAYS[name]}, got {array.shape}")
    return array


def load(path: Path, *, steps: bool = True) -> Recording:
    """Read and check a recorded episode; without `steps`, quickly and without its arrays.

    Raises:
        ValueError: The file has another schema, is damaged or was changed after it was saved, or is
            not a recording. The message is one line.
        OSError: The file cannot be read.
    """
    try:
        arrays = read_npz(path, MAX_BYTES, only=None if steps else HEADER)
        header = from_json(str(arrays[HEADER]))
        require_header(header)
        saved = arrays.pop(HASH, None) if steps else None
        if saved is not None and str(saved) != content_hash(arrays):
            raise ValueError("it was changed after it was saved")
        if steps and saved is None and header["schema_version"] == SCHEMA_VERSION:
            raise ValueError("its content hash is missing")
        del arrays[HEADER]
        if steps:
            require_steps(header, arrays)
            require_agreement(header, len(arrays["time_s"]))
    except (KeyError, ValueError) as error:
        why = error if is_zipfile(path) else "it is no .npz file"
        raise ValueError(f"{path} is damaged, or no recording: {why}") from error
    parts: dict[str, Any] = {name: header[name] for name in PARTS}
    parts |= {name: tuple(header[name]) for name in ("instructions", *NOTES)}
    return Recording(**parts, sha256=None if saved is None else str(saved), arrays=arrays)
