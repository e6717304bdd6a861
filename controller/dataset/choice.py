"""Choose the episodes of a dataset that a training uses."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

ROUNDING = 1e-9  # beyond the error of a share times a number of episodes


@dataclass(frozen=True, kw_only=True)
class Choice:
    """The first share of a dataset's episodes, without some kinds of them.

    Attributes:
        leave_out: Kinds to leave out, as before the colon in a header's `kind`.
        share: Share of each dataset's episodes, above 0 and at most 1; the number is rounded up.

    Raises:
        ValueError: The share is out of range.
    """

    leave_out: Sequence[str] = ()
    share: float = 1.0

    def __post_init__(self) -> None:
        if not 0.0 < self.share <= 1.0:
            raise ValueError(f"share must be above 0 and at most 1, got {self.share:g}")

    def of(self, rows: Sequence[Mapping[str, Any]]) -> list[bool]:
        """Return for each episode's row, which has its `kind`, whether the episode is chosen."""
        first = math.ceil(self.share * len(rows) - ROUNDING)  # 0.07 of 100 is 7
        kinds = (row["kind"].partition(":")[0] for row in rows)
        return [k < first and kind not in self.leave_out for k, kind in enumerate(kinds)]


ALL = Choice()
