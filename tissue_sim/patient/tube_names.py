"""Name the cystic tubes as the endoscope shows them; the names are the same for every patient.

Which of the left and the right tube is the duct differs between patients.
"""

from __future__ import annotations

from typing import Literal, get_args

Tube = Literal["left", "right", "third"]
"""The tubes as the endoscope shows them; a second artery is the third."""

Structure = Literal["duct", "artery", "second artery"]
"""What a tube is in the body."""

TUBES: tuple[Tube, ...] = get_args(Tube)
"""All tubes, in the order of the rows of every table of tubes."""
USUAL_TUBES = TUBES[:2]  # in every patient
OPTIONAL_TUBES = TUBES[2:]  # in part of the patients only

STRUCTURES: tuple[Structure, ...] = get_args(Structure)
"""All structures, the duct first: it is clipped first where the artery crosses it."""
USUAL_STRUCTURES = STRUCTURES[:2]  # of the left and the right tube


def structure_where(tube: Tube, duct: Tube) -> Structure:
    """Return the structure of a tube; `duct` is the duct's tube."""
    if tube in OPTIONAL_TUBES:
        return "second artery"
    return "duct" if tube == duct else "artery"


def tube_where(structure: Structure, duct: Tube) -> Tube:
    """Return the tube of a structure; `duct` is the duct's tube."""
    return next(tube for tube in TUBES if structure_where(tube, duct) == structure)
