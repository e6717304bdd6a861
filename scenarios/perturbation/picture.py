"""Effects on the picture: a bumped endoscope, dye, and faults of the cameras.

Faults of the cameras' pictures change only the estimates of the sense `cameras`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from planner.procedure.task import Task
from scenarios.perturbation.effect import Effect, Once
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.frames import exponential, pose, unit

if TYPE_CHECKING:  # heavy to import
    from torch import Generator, Tensor

    from tissue_sim.world import World

WRISTS = ("wrist_right_tip", "wrist_left_tip")  # in the order in which they go dead


class CameraShift(Once):
    """Shifts the bumped endoscope by `magnitude` m in a random direction.

    The robot knows the endoscope's pose (its holder has encoders). Actions therefore keep their
    meaning: they are in the current endoscope frame. The picture and every position in that frame
    change.
    """

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._change = self.magnitude * unit(rng.normal(size=3))

    def change(self, world: World) -> None:
        world.T_world_endoscope = world.T_world_endoscope @ pose(np.eye(3), self._change)


class CameraTurn(CameraShift):
    """Turns the endoscope by `magnitude` rad about a random axis through its tip."""

    def change(self, world: World) -> None:
        turned = pose(exponential(self._change), np.zeros(3))
        world.T_world_endoscope = world.T_world_endoscope @ turned


class Dye(Once):
    """Colours a share `magnitude` of the tissue's surface red, as in the video of SRT-H.

    Only the picture changes.
    """

    def change(self, world: World) -> None:
        world.conditions = replace(world.conditions, dyed=self.magnitude)


class PictureFault(Effect, ABC):
    """Spoils every picture of a camera alike, for the whole episode."""

    def __init__(self, perturbation: Perturbation, rng: np.random.Generator) -> None:
        super().__init__(perturbation, rng)
        self._seed = int(rng.integers(2**31))

    def before_step(self, world: World, task: Task) -> None:
        """Note the onset."""
        self.begins(world, task)

    def on_picture(self, camera: str, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3) that the camera delivers."""
        import torch

        chance = torch.Generator().manual_seed(self._seed ^ crc32(camera.encode()))
        picture = torch.from_numpy(rgb.copy()).permute(2, 0, 1)[None].float() / 255.0
        spoilt = self.spoilt(camera, picture, chance)[0].permute(1, 2, 0)
        return (255.0 * spoilt).round().clamp(0, 255).to(torch.uint8).numpy()

    @abstractmethod
    def spoilt(self, camera: str, picture: Tensor, chance: Generator) -> Tensor:
        """Return a picture (1, 3, height, width), 0 to 1, with the fault."""


class Smoke(PictureFault):
    """Hides a share `magnitude` of the light behind smoke."""

    def spoilt(self, camera: str, picture: Tensor, chance: Generator) -> Tensor:
        from tissue_sim.sensing.picture_faults import smoked

        return smoked(picture, picture.new_tensor([self.magnitude]), chance)


class LensBlood(PictureFault):
    """Covers a share `magnitude` of each lens with blood."""

    def spoilt(self, camera: str, picture: Tensor, chance: Generator) -> Tensor:
        from tissue_sim.sensing.picture_faults import splashed

        return splashed(picture, picture.new_tensor([self.magnitude]), chance)[0]


class DimLight(PictureFault):
    """Takes a share `magnitude` of all lamps' light."""

    def spoilt(self, camera: str, picture: Tensor, chance: Generator) -> Tensor:
        from tissue_sim.sensing.picture_faults import dimmed

        return dimmed(picture, picture.new_tensor([self.magnitude]))


class WristBlind(PictureFault):
    """Turns one or both wrists' cameras off, the right one first."""

    def spoilt(self, camera: str, picture: Tensor, chance: Generator) -> Tensor:
        return 0.0 * picture if camera in WRISTS[: round(self.magnitude)] else picture
