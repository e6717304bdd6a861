"""What may change in the field in the course of an operation, beside what the instruments do."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Shares, 0 to 1.

    Attributes:
        grip: of the friction that the grasper's jaws have when they are dry.
        dyed: of the tissue's surface, under red liquid; it is only seen.

    Raises:
        ValueError: a share is outside 0 to 1.
    """

    grip: float = 1.0
    dyed: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"conditions: {field.name} = {value} is outside 0 to 1")
