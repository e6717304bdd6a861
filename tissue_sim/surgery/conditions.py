"""Define the conditions of the field that may change during an operation, except instruments."""

from __future__ import annotations

from dataclasses import dataclass, fields


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Shares from 0 to 1.

    Attributes:
        grip: friction of the grasper's jaws over their friction when dry.
        dyed: share of the tissue's surface under red liquid; it changes only the appearance.

    Raises:
        ValueError: a share is outside 0 to 1.
    """

    grip: float = 1.0
    dyed: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"conditions: {field.name} = {value} must be from 0 to 1")
