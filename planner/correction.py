"""Define SRT-H's 18 corrective instructions (arXiv 2505.10251): 12 for an arm, 6 for the jaws."""

from dataclasses import dataclass
from typing import Literal

Arm = Literal["left", "right", "both"]
Direction = Literal["left", "right", "higher", "lower", "away", "towards"]
JawMotion = Literal["close", "open"]

_ARMS: tuple[Arm, ...] = ("left", "right")
_DIRECTION_WORDS: dict[Direction, str] = {
    "left": "to the left",
    "right": "to the right",
    "higher": "higher",
    "lower": "lower",
    "away": "away from me",
    "towards": "towards me",
}
_GRIPPER_WORDS: dict[Arm, str] = {
    "both": "both grippers",
    "left": "left gripper",
    "right": "right gripper",
}
_JAW_MOTIONS: tuple[JawMotion, ...] = ("close", "open")

DIRECTION_ENDOSCOPE: dict[Direction, tuple[float, float, float]] = {
    "left": (1.0, 0.0, 0.0),
    "right": (-1.0, 0.0, 0.0),
    "higher": (0.0, 1.0, 0.0),
    "lower": (0.0, -1.0, 0.0),
    "away": (0.0, 0.0, 1.0),
    "towards": (0.0, 0.0, -1.0),
}
"""Unit vector of each direction in the endoscope frame: +x = left, +y = higher, +z = away."""


@dataclass(frozen=True, kw_only=True)
class Correction:
    """A small motion of an arm or of the jaws that is requested during a task.

    Attributes:
        text: The words of a surgeon, unique to the correction.
        arm: The arm that moves; "both" is for the jaws only.
        direction: Direction of the arm's motion; None for a correction of the jaws.
        jaw: Motion of the jaws; None for a correction of an arm.
    """

    text: str
    arm: Arm
    direction: Direction | None = None
    jaw: JawMotion | None = None

    @property
    def rows(self) -> list[int]:
        """Return the rows of the arms that move; the left arm has row 0, the right one row 1."""
        return {"left": [0], "right": [1], "both": [0, 1]}[self.arm]


CORRECTIONS: tuple[Correction, ...] = (
    *(
        Correction(text=f"move {arm} arm {words}", arm=arm, direction=direction)
        for arm in _ARMS
        for direction, words in _DIRECTION_WORDS.items()
    ),
    *(
        Correction(text=f"{jaw} {words}", arm=arm, jaw=jaw)
        for jaw in _JAW_MOTIONS
        for arm, words in _GRIPPER_WORDS.items()
    ),
)

OPPOSITE = {
    "left": "right", "right": "left", "higher": "lower", "lower": "higher",
    "away": "towards", "towards": "away", "open": "close", "close": "open",
}  # fmt: skip
_BY_TEXT = {correction.text: correction for correction in CORRECTIONS}


def correction_from_text(text: str) -> Correction:
    """Return the correction with this text.

    Raises:
        ValueError: No correction has this text; the message lists the 18 allowed texts.
    """
    try:
        return _BY_TEXT[text]
    except KeyError:
        raise ValueError(f"unknown correction {text!r}; allowed: {', '.join(_BY_TEXT)}") from None


def opposite(correction: Correction) -> Correction:
    """Return the correction that moves the other way."""
    way = OPPOSITE[correction.direction or correction.jaw or ""]
    return next(c for c in CORRECTIONS if c.arm == correction.arm and way in (c.direction, c.jaw))
