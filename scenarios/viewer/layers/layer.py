"""What all layers share."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import trimesh
from numpy.typing import NDArray
from viser.transforms import SO3

from scenarios.viewer.frame import Frame
from tissue_sim.textures import Colour

Rgb = tuple[int, int, int]


class Layer(Protocol):
    """One kind of thing on the page, made for one patient: `Layer(scene, root, patient)`.

    Its nodes lie under `root` in viser's tree, in the world frame.
    """

    def update(self, frame: Frame) -> None:
        """Look as in this frame; what has not changed is not sent."""
        ...


def srgb(linear: Colour) -> Rgb:
    """A linear colour, 0 to 1, as the page wants it."""
    red, green, blue = (round(255 * float(np.clip(c, 0.0, 1.0)) ** (1 / 2.2)) for c in linear)
    return red, green, blue


def glb(*meshes: trimesh.Trimesh) -> bytes:
    """A file of meshes with their materials, as the page takes it."""
    made = trimesh.Scene(meshes).export(file_type="glb", include_normals=True)
    assert isinstance(made, bytes)
    return made


def wxyz(rotations: NDArray[np.floating]) -> NDArray[np.floating]:
    """(..., 4) quaternions of rotations (..., 3, 3)."""
    return SO3.from_matrix(rotations).wxyz
