"""Name the cystic tubes as the endoscope shows them; the names are the same for every patient."""

from __future__ import annotations

from typing import Literal, get_args

Tube = Literal["left", "right", "third"]
"""The tubes as the endoscope shows them; a second artery is the third."""

TUBES: tuple[Tube, ...] = get_args(Tube)
USUAL_TUBES = TUBES[:2]  # in every patient
