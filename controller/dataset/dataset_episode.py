"""Represent one demonstrated episode in memory."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from controller.dataset.schema import SCHEMA_VERSION
from tissue_sim.constants import WORLD_VERSION


@dataclass(frozen=True, kw_only=True)
class Header:
    """The description of an episode, without its frames.

    Attributes:
        seed: Seed of the patient and of everything random.
        kind: Kind of the episode, as in the column of that name.
        scenario: A key of the scenarios' catalogue.
        success: Whether the procedure passed.
        failures: Reasons why the procedure did not pass: injuries, tasks that were not done.
        anatomy: The patient's anatomy, as plain data.
        versions: Name to version of the software that made the episode.
        cameras: Names of the cameras whose videos lie beside the frames.
        sense: The sense that observed the episode; "" if an older version wrote it.
        checkpoints: SHA-256 of the acting policies' checkpoints, by role. Without `sense` these
            are unknown.
    """

    seed: int
    kind: str
    scenario: str
    success: bool
    failures: Sequence[str]
    anatomy: Mapping[str, Any]
    versions: Mapping[str, str]
    cameras: Sequence[str] = ()
    sense: str = ""
    checkpoints: Mapping[str, str] = field(default_factory=dict)
    world_version: int = WORLD_VERSION
    schema_version: int = SCHEMA_VERSION


@dataclass(frozen=True, kw_only=True)
class DatasetEpisode:
    """Frames of one episode, 30 a second.

    Attributes:
        columns: The requested columns, by their names in `schema.features`: (n,) or (n, size);
            strings are objects.
    """

    header: Header
    columns: Mapping[str, np.ndarray]

    def __len__(self) -> int:
        return len(next(iter(self.columns.values())))

    def stretches(self) -> list[slice]:
        """Return runs of frames that the expert alone led, without a tool exchange.

        A chunk of actions to imitate must lie within one run; the frames before the chunk may lie
        outside. The method needs the columns `expert` and `segment`.
        """
        expert, segment = self.columns["expert"], self.columns["segment"]
        run = np.where(expert, segment, -1)
        starts = np.flatnonzero(np.diff(run, prepend=-2))
        ends = [*starts[1:].tolist(), len(run)]
        return [slice(a, b) for a, b in zip(starts.tolist(), ends, strict=True) if expert[a]]
