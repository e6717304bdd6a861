"""Measure how far the observed tubes and structures at risk are off, and how thick they count.

The safety filter keeps tools off what is observed. The expert chooses a way that the filter leaves
open, so it measures room to the same lines. Errors change slowly: those at a task's begin hold for
the task.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from controller.safety.seen_obstacles import LineSeen, lines_seen, thicker_m
from tissue_sim.frames import Array, transform
from tissue_sim.patient.mesher import subdivide
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.polyline import nearest_on, place_on

if TYPE_CHECKING:
    from tissue_sim.world import World

LINE_PARTS = 5  # between a structure's rings


@dataclass(frozen=True, kw_only=True)
class LineErrors:
    """Errors of the observed lines of tubes and structures at risk, by the structure's name.

    Attributes:
        off_m: (n, 3) from the middle of each ring to the observed line, world frame.
        more_m: (n,) by how much the filter takes the structure for thicker at each ring.
    """

    off_m: Mapping[str, Array] = field(default_factory=dict)
    more_m: Mapping[str, Array] = field(default_factory=dict)

    def line(self, world: World, name: str) -> tuple[Array, Array]:
        """Return a structure's present line with these errors: points (n, 3), and radii (n,)."""
        centres_m, radius_m = world.tubes.centres(name), world.tubes.radius_m(name)
        off_m = self.off_m.get(name, np.zeros(3))
        more_m = self.more_m.get(name, np.zeros(len(centres_m)))
        return subdivide(centres_m + off_m, LINE_PARTS), subdivide(radius_m + more_m, LINE_PARTS)


NO_ERRORS = LineErrors()


def line_errors(world: World, observation: Observation) -> LineErrors:
    """Return the errors of all observed lines; a severed tube counts as observed without any."""
    off_m, more_m = {}, {}
    for name, line in lines_seen(observation).items():
        if name in world.organ.hollow and not line.severed:
            centres_m = world.tubes.centres(name)
            off_m[name], more_m[name] = _compare(centres_m, line, observation.T_world_endoscope)
    return LineErrors(off_m=off_m, more_m=more_m)


def _compare(centres_m: Array, line: LineSeen, T_world_endoscope: Array) -> tuple[Array, Array]:
    points_m = transform(T_world_endoscope, line.points_m)
    nearest = [nearest_on(points_m, centre)[:2] for centre in centres_m]
    off_m = np.stack([place_on(points_m, k + share) for k, share in nearest]) - centres_m
    std_m = np.array([line.std_m[k : k + 2].max() for k, _ in nearest])
    return off_m, thicker_m(std_m)
