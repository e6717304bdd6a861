"""One demonstrated episode in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from controller.dataset.schema import SCHEMA_VERSION
from tissue_sim.version import WORLD_VERSION


@dataclass(frozen=True, kw_only=True)
class Header:
    """What an episode is, beside its frames.

    Attributes:
        seed: of the patient and of everything random.
        kind: as in the column of that name.
        scenario: a key of the scenarios' catalogue.
        success: whether the procedure was passed.
        failures: what stood against that: injuries, tasks that were not done.
        anatomy: of the patient, as plain data.
        versions: name to version of what it was made with.
    """

    seed: int
    kind: str
    scenario: str
    success: bool
    failures: Sequence[str]
    anatomy: Mapping[str, Any]
    versions: Mapping[str, str]
    world_version: int = WORLD_VERSION
    schema_version: int = SCHEMA_VERSION


@dataclass(frozen=True, kw_only=True)
class DatasetEpisode:
    """Frames of one episode, 30 a second.

    Attributes:
        columns: those that were asked for, by their names in `schema.FEATURES`: (n,) or (n, size);
            strings are objects.
    """

    header: Header
    columns: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def stretches(self) -> list[slice]:
        """Runs of frames in which the expert alone led, unbroken by an exchange of tools.

        What is imitated, a chunk of actions from first to last, must lie within one of them. What
        was seen before may lie outside. Needs the columns `expert` and `segment`.
        """
        expert, segment = self.columns["expert"], self.columns["segment"]
        run = np.where(expert, segment, -1)
        starts = np.flatnonzero(np.diff(run, prepend=-2))
        ends = [*starts[1:].tolist(), len(run)]
        return [slice(a, b) for a, b in zip(starts.tolist(), ends, strict=True) if expert[a]]
