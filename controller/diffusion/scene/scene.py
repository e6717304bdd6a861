"""Derive facts from a control step's observation for the rules on chunks, each fact once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from controller.diffusion.scene.gallbladder import wall_distance_m
from controller.diffusion.scene.places import places_on
from planner.scene.predicates import is_grasped
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES, Tube
from tissue_sim.sensing.observation import Observation, fields, observation_of
from tissue_sim.sensing.tissue_features import per_tube


@dataclass(frozen=True, kw_only=True)
class TubePlaces:
    """The places of a tube's clips and of its cut, by the rows of `places.Places`.

    Attributes:
        points_m: (9, 3) points on the centreline, endoscope frame.
        along: (9, 3) unit vectors up the tube.
        wall_m: (9,) distances from the gallbladder's wall.
    """

    points_m: Array
    along: Array
    wall_m: Array


@dataclass(frozen=True, eq=False)
class Scene:
    """One observation, and the facts that follow from the observation.

    Attributes:
        vector: The `Observation.vector()`.
        is_corrected: Whether a correction is in force.
    """

    vector: NDArray[np.float32]
    is_corrected: bool = False

    @cached_property
    def observation(self) -> Observation:
        """Return the observation that the vector encodes."""
        return observation_of(self.vector, 0.0)

    @cached_property
    def fields(self) -> dict[str, Tensor]:
        """Return the vector's parts (1, ...) by name."""
        return {
            name: torch.from_numpy(part[None].copy()) for name, part in fields(self.vector).items()
        }

    @cached_property
    def is_grasped(self) -> bool:
        """Return whether the grasp surely holds the gallbladder and spreads the tubes."""
        return is_grasped(self.observation)

    def places_on(self, tube: Tube) -> TubePlaces:
        """Return the places of a tube's clips and of its cut."""
        return self._places[TUBES.index(tube)]

    @cached_property
    def _places(self) -> tuple[TubePlaces, ...]:
        places = places_on(self.fields)
        axis_m, radius_m = (per_tube(self.fields[name]) for name in ("sac_m", "sac_radius_m"))
        wall_m = wall_distance_m(axis_m, radius_m, places.points_m)
        parts = (part.numpy().astype(float) for part in (places.points_m, places.along, wall_m))
        each = zip(*parts, strict=True)
        return tuple(
            TubePlaces(points_m=points_m, along=along, wall_m=far_m)
            for points_m, along, far_m in each
        )
