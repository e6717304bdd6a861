"""Coloured liquid on the tissue: only the picture changes."""

from __future__ import annotations

from dataclasses import replace

from scenarios.perturbation.once import Once
from tissue_sim.world import World


class Dye(Once):
    """Colours a share `magnitude` of the tissue's surface red, as in the video of SRT-H."""

    def change(self, world: World) -> None:
        world.conditions = replace(world.conditions, dyed=self.magnitude)
