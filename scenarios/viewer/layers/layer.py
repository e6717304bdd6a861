"""What all layers share."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import trimesh
import viser
from numpy.typing import NDArray
from viser.transforms import SO3

from scenarios.viewer.frame import Frame
from tissue_sim.rendering.textures import Colour

Rgb = tuple[int, int, int]
SEEN_M = 5e-5  # less than a pixel of a page that fills a screen
SEEN_TURN = 5e-4  # of a quaternion's parts: 0.06 degrees


class Layer(Protocol):
    """One kind of thing on the page, made for one patient: `Layer(scene, root, patient)`.

    Its nodes lie under `root` in viser's tree, in the world frame.
    """

    def update(self, frame: Frame) -> None:
        """Look as in this frame; what has not changed is not sent."""
        ...


def show(node: viser.SceneNodeHandle, name: str, value: NDArray, least: float = SEEN_M) -> None:
    """Set an array of a node, unless it is shown already but for what nobody would see.

    Assigning takes viser 30 us, and a message; this takes 4 us where nothing is to be seen.
    """
    value, shown = value.astype(np.float32), getattr(node, name)
    if shown.shape != value.shape or (np.abs(shown - value) > least).any():
        setattr(node, name, value)


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
