"""Check that a folder's episodes were made in the same way as those that join it.

Without the check nobody would know the origin of a data set. Files of older versions of Calot do
not record their sense and checkpoints: anything may join them.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from planner.learning.files import DAMAGED
from scenarios.demonstration.demonstrate import FAILED, PARTS, checkpoints_of
from scenarios.demonstration.mix import FAILING, PlannedDemonstration
from scenarios.demonstration.pictures import MADE_WITH
from scenarios.files.errors import BadInputError, refusing
from tissue_sim.constants import WORLD_VERSION

if TYPE_CHECKING:  # heavy to import
    from controller.dataset.dataset_episode import Header

_OPTIONS = {"controller": "--checkpoint", "planner": "--planner-checkpoint"}
_ELSE = "name the same, or choose another --out"


def headers_in(out: Path) -> Iterator[tuple[Path, Header]]:
    """Yield the parts in a folder, failed ones too, with their headers.

    Raises:
        BadInputError: A part is damaged, or of another schema or world.
    """
    from controller.dataset.part import header_of

    for part in sorted(path for name in (PARTS, FAILED) for path in (out / name).glob("*.parquet")):
        with refusing(ValueError):
            header = header_of(part)
        yield part, header


def require_alike(out: Path, asked: Sequence[PlannedDemonstration], cameras: Sequence[str]) -> None:
    """Check that a folder's episodes were made like the requested ones, which may be none.

    Episodes of one kind share their checkpoints.

    Raises:
        BadInputError: Cameras, sense or checkpoints differ, or a part cannot be read.
    """
    made = {d.family: checkpoints_of(d) for d in {d.family: d for d in asked}.values()}
    for part, header in headers_in(out):
        if (there := tuple(header.cameras)) != tuple(cameras):
            filmed = ", ".join(there) or "no camera"
            raise BadInputError(
                f"--cameras: the episodes in {out} were filmed by {filmed}: {_ELSE}"
            )
        if not header.sense:
            continue
        if asked and header.sense != asked[0].sense:
            raise BadInputError(
                f"--sense {asked[0].sense}: the episodes in {out} are of the sense {header.sense}:"
                f" {_ELSE}"
            )
        family = header.kind.partition(FAILING)[0]
        _require_same(part, header.checkpoints, made.get(family, header.checkpoints))


def require_joinable(out: Path, sense: str) -> None:
    """Check that interventions may join a folder's episodes.

    Raises:
        BadInputError: The folder's episodes were filmed or have another sense, or a part cannot be
            read.
    """
    for part, header in headers_in(out):
        if header.cameras:
            raise BadInputError(f"--save-interventions: {part} was filmed: choose another folder")
        if header.sense not in ("", sense):
            raise BadInputError(
                f"--save-interventions: {part} is of the sense {header.sense}, these of {sense}:"
                " choose another folder"
            )


def require_pictures_alike(out: Path, asked: Sequence[PlannedDemonstration]) -> None:
    """Check that a folder's pictures are of this world, and of the same learned controller.

    Raises:
        BadInputError: World or controller differ, or a file cannot be read.
    """
    learned = next((d for d in asked if d.is_rollout), None)
    for path in sorted(out.glob("*.npz")):
        made = _made_with(path)
        if (world := made.get("world_version", WORLD_VERSION)) != WORLD_VERSION:
            raise BadInputError(
                f"--out: {path} is of world version {world}, not {WORLD_VERSION}: choose another"
                " folder"
            )
        if learned is not None and (there := made.get("checkpoints")):
            _require_same(path, there, checkpoints_of(learned))


def _made_with(path: Path) -> dict[str, Any]:
    from controller.dataset.part import one_line

    try:
        with np.load(path) as file:
            return json.loads(str(file[MADE_WITH])) if MADE_WITH in file else {}
    except (OSError, ValueError, *DAMAGED) as error:
        raise BadInputError(f"--out: {path} is damaged: {one_line(error)}") from None


def _require_same(path: Path, there: Mapping[str, str], asked: Mapping[str, str]) -> None:
    for role, option in _OPTIONS.items():
        if there.get(role) != asked.get(role):
            raise BadInputError(f"{option}: the {role} in {path} is another one: {_ELSE}")
