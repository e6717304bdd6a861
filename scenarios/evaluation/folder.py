"""A report's folder: how its episodes are made, and which are finished."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from planner.learning.atomic_write import write_atomic
from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.case import Case
from scenarios.evaluation.outside import outside
from scenarios.evaluation.plan import Plan
from scenarios.files.errors import BadInputError
from scenarios.files.names import MANIFEST, RESULTS
from scenarios.files.strict_json import dumps, plain
from scenarios.files.versions import source_digest, versions
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.loop.results import EpisodeResult, episode_from
from scenarios.recording.checkpoint_digests import checkpoint_digests
from scenarios.recording.recorder import load
from scenarios.recording.schema import SCHEMA_VERSION
from tissue_sim.version import WORLD_VERSION

SCHEMA = 1


def open_folder(folder: Path, arms: Iterable[StudyArm]) -> None:
    """Note how the folder's episodes are made, or check that this has not changed.

    Raises:
        BadInputError: its episodes have another version, an arm of the same name differs, or it
            holds the results of `calot run`.
    """
    path, made_with = folder / MANIFEST, _made_with()
    if (folder / RESULTS).exists() and not path.exists():
        raise BadInputError(f"--out {folder}: it has results of `calot run`; name another folder")
    before = _read(path) or {"schema": SCHEMA, "made_with": made_with, "arms": {}}
    for name, value in made_with.items():
        if before["made_with"].get(name) != value:
            raise BadInputError(
                f"--out {folder}: its episodes are of {name} {before['made_with'].get(name)}, this"
                f" is {value}; name another folder"
            )
    for arm in arms:
        described = _described(arm)
        if before["arms"].setdefault(arm.name, described) != described:
            raise BadInputError(
                f"--out {folder}: arm {arm.name!r} was another one there; give it another name, or"
                " name another folder"
            )
    try:
        write_atomic(path, (dumps(before, indent=2) + "\n").encode())
    except OSError as error:
        raise BadInputError(f"--out: cannot write {path} ({error.strerror})") from None


def finished(folder: Path, plan: Plan) -> dict[Case, EpisodeResult]:
    """Return the results of finished episodes; those that broke off run again.

    Raises:
        BadInputError: a recording cannot be read.
    """
    found: dict[Case, EpisodeResult] = {}
    while new := {
        c: r for c in plan.due(found) if (r := _result(folder / c.recording)) is not None
    }:
        found |= new
    return found


def _result(path: Path) -> EpisodeResult | None:
    if not path.exists():
        return None
    try:
        recording = load(path, steps=False)
    except (OSError, ValueError) as error:
        raise BadInputError(f"--out: {error}; remove it, or name another folder") from None
    return None if recording.result is None else episode_from(recording.result)


def _read(path: Path) -> dict[str, Any] | None:
    """Return the content of the file; None if there is no file yet."""
    try:
        read = json.loads(path.read_text())
        if read["schema"] == SCHEMA and read["made_with"].keys() and read["arms"] is not None:
            return read
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise BadInputError(f"--out: {path} is damaged; name another folder") from None
    raise BadInputError(
        f"--out: {path} has schema {read['schema']}; allowed: {SCHEMA}; name another folder"
    )


def _made_with() -> dict[str, Any]:
    made = {"world version": WORLD_VERSION, "recording schema": SCHEMA_VERSION}
    return made | {"source": source_digest()} | versions()


def _described(arm: StudyArm) -> dict[str, Any]:
    """Return the arm as plain data, with checkpoints and a user's code by content, not by path."""
    choices = {k: v for k, v in arm.choices.items() if not k.endswith("checkpoint")}
    digests = checkpoint_digests(EpisodeConfig(**arm.choices))
    return plain(choices) | {"checkpoints": digests} | outside(arm)
