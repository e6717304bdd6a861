"""A report's folder: the origin of its episodes, and the list of finished ones.

Part of the origin is what is not part of Calot: a user's modules, or a language model.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

from msgspec import Struct, convert

from planner.learning.files import from_json, write_atomic
from scenarios.catalogue import policy_named
from scenarios.evaluation.arm import StudyArm
from scenarios.evaluation.case import Case
from scenarios.evaluation.plan import Plan
from scenarios.files.errors import BadInputError, refusing
from scenarios.files.strict_json import dumps, plain
from scenarios.files.sums import MANIFEST, RESULTS, SUMS, add_sum, digest_of, read_sums
from scenarios.files.versions import source_digest, versions
from scenarios.loop.episode_config import EpisodeConfig, checkpoint_digests
from scenarios.loop.results import EpisodeResult
from scenarios.perturbation.effects import Effects
from scenarios.recording.recorder import Recording, load
from scenarios.recording.schema import SCHEMA_VERSION
from scenarios.run_episode import anatomy_of
from tissue_sim.constants import WORLD_VERSION

SCHEMA = 1


def open_folder(folder: Path, arms: Iterable[StudyArm]) -> None:
    """Record how the folder's episodes are made, or check that their origin has not changed.

    Raises:
        BadInputError: Its episodes have another version, or a system of the same name differs. Or
            the folder holds the results of `calot run`.
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
    with refusing(OSError, before=f"--out: cannot write {path} (", after=")"):
        write_atomic(path, (dumps(before, indent=2) + "\n").encode())


def finished(folder: Path, plan: Plan) -> dict[Case, EpisodeResult]:
    """Return the results of finished episodes; those that broke off run again.

    A recording's hash is recorded if the folder's list lacks it.

    Raises:
        BadInputError: A recording cannot be read, was changed after it was saved, or is of another
            episode. Or the list cannot be written.
    """
    try:
        sums = read_sums(folder)
    except (OSError, ValueError) as error:
        raise BadInputError(f"--out: {error}; remove it, or name another folder") from None
    digests = {arm: checkpoint_digests(EpisodeConfig(**arm.stack)) for arm in plan.arms}
    found: dict[Case, EpisodeResult] = {}
    while new := {
        case: result
        for case in plan.due(found)
        if (result := _result(folder, case, sums, digests[case.arm])) is not None
    }:
        found |= new
    with refusing(OSError, before=f"--out: cannot write {folder / SUMS} (", after=")"):
        for case in found:
            if str(case.recording) not in sums:
                note(folder, case)
    return found


def note(folder: Path, case: Case) -> None:
    """Record the hash of a finished episode's recording, unless the recording was moved away.

    Raises:
        OSError: The list cannot be written.
    """
    with suppress(FileNotFoundError):
        add_sum(folder, str(case.recording))


def _result(
    folder: Path, case: Case, sums: Mapping[str, str], checkpoints: Mapping[str, str]
) -> EpisodeResult | None:
    path = folder / case.recording
    if not path.exists():
        return None
    try:
        recording = load(path)
        if recording.result is None:
            return None
        if digest_of(path) != sums.get(str(case.recording), digest_of(path)):
            raise ValueError(f"{path} was changed after it was saved: see {SUMS}")
        _require_case(path, recording, case, checkpoints)
        return convert(recording.result, EpisodeResult)
    except (OSError, ValueError) as error:
        raise BadInputError(f"--out: {error}; remove it, or name another folder") from None


def _require_case(
    path: Path, recording: Recording, case: Case, checkpoints: Mapping[str, str]
) -> None:
    """Check that a recording is of the case's patient, conditions, policies and checkpoints."""
    expected = plain(case.config)
    for name, value in expected.items():
        if recording.config[name] != value:
            raise ValueError(f"{path} is of {name} {recording.config[name]!r}, not {value!r}")
    if recording.checkpoints != checkpoints:
        raise ValueError(f"{path} was made with other checkpoints")
    if recording.world_version != WORLD_VERSION:
        raise ValueError(f"{path} is of world version {recording.world_version}")
    own = Effects(case.config.perturbations, case.seed).on_anatomy(anatomy_of(case.config))
    if recording.anatomy not in (None, plain(own)):
        raise ValueError(f"{path} is of another patient")


class _Manifest(Struct, kw_only=True):
    schema: Literal[1]
    made_with: dict[str, str | int]
    arms: dict[str, dict[str, Any]]


def _read(path: Path) -> dict[str, Any] | None:
    """Return the content of the file; None if there is no file yet."""
    if not path.exists():
        return None
    try:
        read = from_json(path.read_bytes())
        if isinstance(found := read["schema"], int) and found != SCHEMA:
            why = f"has schema {found}; allowed: {SCHEMA}"
        else:
            convert(read, _Manifest)
            return read
    except (OSError, ValueError, KeyError, TypeError):
        why = "is damaged"
    raise BadInputError(f"--out: {path} {why}; name another folder")


def _made_with() -> dict[str, Any]:
    made = {"world version": WORLD_VERSION, "recording schema": SCHEMA_VERSION}
    return made | {"source": source_digest()} | versions()


def _described(arm: StudyArm) -> dict[str, Any]:
    """Return the system as plain data: checkpoints and users' code by content, not by path."""
    choices = {k: v for k, v in arm.stack.items() if not k.endswith("checkpoint")}
    digests = checkpoint_digests(EpisodeConfig(**arm.stack))
    return plain(choices) | {"checkpoints": digests} | _outside(arm)


def _outside(arm: StudyArm) -> dict[str, str]:
    """Return the SHA-256 of each policy's own code, and the language model's name, as far as used.

    Raises:
        BadInputError: A policy's module has no file.
        OSError: A file cannot be read.
        ValueError: The environment names no language model.
    """
    found = {f"{role} code": _code_digest(name) for role, name in arm.outside.items()}
    if policy_named(arm.planner).endpoint:
        from planner.chat_endpoint import endpoint_from_environment

        found["language model"] = endpoint_from_environment().model
    return found


def _code_digest(name: str) -> str:
    """Return the SHA-256 of the file of a policy's module, or of all *.py of its whole package."""
    contents = (f"{file.name}\n".encode() + file.read_bytes() for file in _files(name))
    return sha256(b"\0".join(contents)).hexdigest()


def _files(name: str) -> list[Path]:
    package = name.partition(":")[0].partition(".")[0]
    spec = find_spec(package)
    if spec is None or not (spec.submodule_search_locations or spec.has_location):
        raise BadInputError(f"--arms: {name}: the module {package} has no file")
    if folders := spec.submodule_search_locations:
        return sorted(file for folder in folders for file in Path(folder).rglob("*.py"))
    return [Path(spec.origin or "")]
