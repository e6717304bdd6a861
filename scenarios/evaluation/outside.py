"""A system's parts that are not part of Calot: a user's modules, or a language model."""

from __future__ import annotations

from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path

from scenarios.catalogue import policy_named
from scenarios.evaluation.arm import StudyArm
from scenarios.files.errors import BadInputError


def outside(arm: StudyArm) -> dict[str, str]:
    """Return the SHA-256 of each policy's own code, and the language model's name, as far as used.

    Raises:
        BadInputError: A policy's module has no file.
        OSError: A file cannot be read.
        ValueError: The environment names no language model.
    """
    found = {f"{role} code": _digest(name) for role, name in arm.outside.items()}
    if policy_named(arm.planner).endpoint:
        from planner.chat_endpoint import endpoint_from_environment

        found["language model"] = endpoint_from_environment().model
    return found


def _digest(name: str) -> str:
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
