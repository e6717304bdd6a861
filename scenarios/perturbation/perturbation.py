"""The configuration of one disturbance of an episode; light to import."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class AtTask:
    """Onset during a task: its index, 1 to 25."""

    index: int


@dataclass(frozen=True, kw_only=True)
class AtTime:
    """Onset at a simulated time."""

    time_s: float


Onset = AtTask | AtTime


@dataclass(frozen=True, kw_only=True)
class Perturbation:
    """A disturbance with a magnitude, so that the magnitude that breaks a policy can be found.

    Attributes:
        name: Name in scenarios and recordings.
        effect: Path of the subclass of `scenarios.perturbation.effect.Effect` that applies it.
        magnitude: From 0 (no effect: the episode is identical to the bit) to `most`.
        unit: Unit of the magnitude.
        whole: Whether the magnitude must be a whole number.
        at: The onset; None draws it from the episode's seed.

    Raises:
        ValueError: The magnitude is not allowed.
    """

    name: str
    description: str
    effect: str
    magnitude: float
    most: float
    unit: str
    whole: bool = False
    at: Onset | None = None

    def __post_init__(self) -> None:
        allowed = 0.0 <= self.magnitude <= self.most
        if not allowed or (self.whole and self.magnitude != int(self.magnitude)):
            kind = "a whole number" if self.whole else "a number"
            raise ValueError(
                f"{self.name}: magnitude = {self.magnitude:g} must be {kind} from 0 to "
                f"{self.most:g} ({self.unit})"
            )


Row = tuple[str, str, float, float, str, str]


def table(*rows: Row, at: Onset | None = None) -> tuple[Perturbation, ...]:
    """Return the perturbations of rows: name, effect, magnitude, most, unit, description.

    An effect is MODULE:CLASS of this folder. A whole default magnitude, such as 1, allows whole
    numbers only.
    """
    return tuple(
        Perturbation(
            name=name,
            effect=f"scenarios.perturbation.{effect}",
            magnitude=magnitude,
            most=most,
            unit=unit,
            description=description,
            whole=isinstance(magnitude, int),
            at=at,
        )
        for name, effect, magnitude, most, unit, description in rows
    )
