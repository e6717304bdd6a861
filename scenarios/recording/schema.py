"""The schema of a recording: the required parts of its file, and the parts that must agree.

A file may come from anybody, so the whole file is checked before any part of it is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import fields
from itertools import chain
from typing import Annotated, Any, Literal

import msgspec
import numpy as np
from msgspec import Meta, Struct
from numpy.typing import NDArray

from controller.safety.ledger import Entry
from planner.command import COMMANDS
from planner.instruction import Source
from scenarios.catalogue import CHOLECYSTECTOMY, PROCEDURES, procedure_named
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult
from scenarios.perturbation.perturbations import MANUAL
from tissue_sim.constants import CONTROL_HZ
from tissue_sim.tools.instruments import right_tools

SCHEMA_VERSION = 9
READABLE = (7, 8, SCHEMA_VERSION)  # 7 has no content hash
NEW_IN = {8: {"act_limit_s"}, 9: {"procedure"}}  # entries of the configuration, by version
MOST_TOOLS = 16  # on the right arm; a procedure from outside may bring tools

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
"""The notes that only some steps have; each entry has its `step`."""

PARTS = ("config", "versions", "world_version", "checkpoints", "anatomy", "result", "error")
"""The other parts of a header, besides its schema and the table of instructions."""

WHOLE = ("instruction", "right_tool", "clip_loaded")

MOST_TASKS = 100  # of a procedure
LONGEST_S = 170 * EpisodeConfig.task_cap_s  # ten times what the tasks of a cholecystectomy may take
MAX_STEPS = round(LONGEST_S * CONTROL_HZ)
MAX_NOTES_BYTES = 64_000_000  # of the header: 4 bytes a character
STEP_BYTES = 8 * sum(int(np.prod(shape)) for shape in STEP_ARRAYS.values())
MAX_BYTES = MAX_STEPS * STEP_BYTES + MAX_NOTES_BYTES

Step = Annotated[int, Meta(ge=0, lt=MAX_STEPS)]
Row = Annotated[list[float], Meta(min_length=4, max_length=4)]


class _Noted(Struct, kw_only=True):
    step: Step


class _Event(_Noted):
    event: str
    time_s: float
    value: float | None
    limit: float | None


class _Applied(_Noted):
    name: str
    time_s: float
    magnitude: float
    unit: str


class _Heard(_Noted):
    time_s: float
    text: str
    command: str | None
    then: list[str]
    by: str
    instruction: str | None
    reply: str


class _Told(_Noted):
    text: str


class _Hand(_Noted):
    arm: Annotated[int, Meta(ge=0, le=1)]
    T_world_goal: Annotated[list[Row], Meta(min_length=4, max_length=4)]
    jaw_rad: float


class _Words(Struct, kw_only=True):
    task: Annotated[int, Meta(ge=1, le=MOST_TASKS)]
    text: str
    source: Source
    remark: str
    tool: str = ""


class _Header(Struct, kw_only=True):
    schema_version: Literal[7, 8, 9]
    config: dict[str, Any]
    versions: dict[str, str]
    world_version: int
    checkpoints: dict[Literal["controller", "planner", "perception"], str]
    anatomy: dict[str, Any] | None
    instructions: list[_Words]
    events: list[_Event]
    perturbations: list[_Applied]
    ledger: list[Entry]
    heard: list[_Heard]
    told: list[_Told]
    hands: list[_Hand]
    result: EpisodeResult | None
    error: str | None


def require_header(header: Any) -> None:
    """Check the header of a recording: its keys, their types, and names that must be known.

    Raises:
        ValueError: The header has another form; the message says where and why.
    """
    version = header.get("schema_version") if isinstance(header, dict) else None
    if version not in READABLE:
        raise ValueError(f"it has schema {version!r:.40}; allowed: {SCHEMA_VERSION}")
    msgspec.convert(header, _Header)
    msgspec.convert(header["ledger"], list[_Noted])
    known = {field.name for field in fields(EpisodeConfig)}
    known -= {name for later, names in NEW_IN.items() if later > version for name in names}
    if missing := known - header["config"].keys():
        raise ValueError(f"its configuration lacks {', '.join(sorted(missing))}")
    if not isinstance(header["config"].get("procedure", ""), str):
        raise ValueError("its procedure is no name")
    n_tasks, _ = _most(header)
    if odd := [words["task"] for words in header["instructions"] if words["task"] > n_tasks]:
        raise ValueError(f"its procedure has no task {odd[0]}; allowed: 1 to {n_tasks}")
    for heard in header["heard"]:
        if heard["by"] == "button" and heard["text"] not in COMMANDS:
            raise ValueError(f"no button says {heard['text']!r:.40}")
    for applied in header["perturbations"]:
        most = MANUAL[name].most if (name := applied["name"]) in MANUAL else np.inf
        if abs(applied["magnitude"]) > most:
            raise ValueError(f"{name!r} is of {applied['magnitude']:g}; allowed: up to {most:g}")


def _most(header: Mapping[str, Any]) -> tuple[int, int]:
    """Return the numbers of tasks and right tools that may occur, without importing a procedure."""
    name = header["config"].get("procedure", CHOLECYSTECTOMY)
    if name not in PROCEDURES:
        return MOST_TASKS, MOST_TOOLS
    return len(procedure_named(name).tasks), len(right_tools())


def require_steps(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Check the arrays of a recording, and that the header names only existing steps.

    Raises:
        ValueError: An array is missing or unknown, of another type or shape, or not finite.
    """
    if odd := set(arrays) ^ set(STEP_ARRAYS):
        raise ValueError(f"missing or unknown: {', '.join(sorted(odd))}")
    n = arrays["time_s"].size
    if n > MAX_STEPS:
        raise ValueError(f"it has {n} steps; allowed: {MAX_STEPS}")
    for name, shape in STEP_ARRAYS.items():
        dtype = np.dtype(np.int64 if name in WHOLE else np.float64)
        array = arrays[name]
        if (array.dtype, array.shape) != (dtype, (n, *shape)):
            found = f"{array.dtype} {array.shape}"
            raise ValueError(f"{name} is {found}; expected: {dtype} {(n, *shape)}")
        if not np.isfinite(array).all():
            raise ValueError(f"{name} is not finite everywhere")
    for name, many in (
        ("instruction", len(header["instructions"])),
        ("right_tool", _most(header)[1]),
        ("clip_loaded", 2),
    ):
        if n and not 0 <= arrays[name].min() <= arrays[name].max() < many:
            raise ValueError(f"{name} must be 0 to {many - 1}")
    if n and (arrays["time_s"][0] < 0.0 or not _is_even(arrays["time_s"])):
        raise ValueError(f"time_s does not advance by 1/{CONTROL_HZ} s in each step")
    for entry in chain.from_iterable(header[name] for name in NOTES):
        if entry["step"] >= max(n, 1):
            raise ValueError(f"it notes something in step {entry['step']} of {n}")


def _is_even(time_s: NDArray[np.float64]) -> bool:
    return np.allclose(np.diff(time_s), 1.0 / CONTROL_HZ, rtol=0.0, atol=1e-9)


def require_agreement(header: Mapping[str, Any], n_steps: int) -> None:
    """Check that the result of a recording is that of its configuration, steps and events.

    Raises:
        ValueError: Two parts contradict each other.
    """
    if header["result"] is not None:
        result = msgspec.convert(header["result"], EpisodeResult)
        for what in _contradictions(header, result, n_steps):
            raise ValueError(f"its parts contradict each other: {what}")


def _contradictions(
    header: Mapping[str, Any], result: EpisodeResult, n_steps: int
) -> Iterator[str]:
    for name in ("scenario", "seed", "planner", "controller", "sense"):
        made, told = header["config"][name], getattr(result, name)
        if made != told and not (name in ("planner", "controller") and ":" in told):  # an object
            yield f"{name} {made!r} in the configuration, {told!r} in the result"
    told_s = result.procedure_time_s + result.exchange_time_s
    if abs(told_s - n_steps / CONTROL_HZ) > 1.5 / CONTROL_HZ:
        yield f"{n_steps} steps, and a result of {told_s:.2f} s"
    done = all(task.is_over for task in result.tasks) and bool(result.tasks)
    if result.success and not (done and not result.injuries and result.call is None):
        yield "it succeeded with a task undone, an injury or a call"
    events = [entry["event"] for entry in header["events"]]
    if events != [injury.event for injury in result.injuries[: len(events)]]:
        yield "the injuries of its steps are not those of its result"
    if result.safety.interventions != len(header["ledger"]):
        yield f"{result.safety.interventions} interventions, {len(header['ledger'])} in the ledger"
