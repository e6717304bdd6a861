"""The interface of all layers, and their common conversions."""

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
SEEN_M = 5e-5  # smaller motions are not sent: less than a pixel of a full-screen page
SEEN_TURN = 5e-4  # the same for the components of a quaternion: 0.06 degrees


class Layer(Protocol):
    """One kind of object in the scene, made for one patient by `Layer(scene, root, patient)`.

    Its nodes lie under `root` in viser's tree, in the world frame.
    """

    def update(self, frame: Frame) -> None:
        """Show this frame; send only the visible changes."""
        ...


def show(node: viser.SceneNodeHandle, name: str, value: NDArray, least: float = SEEN_M) -> None:
    """Set an array of a node, unless it differs from the current one by `least` at most.

    Assigning takes viser 30 us and a message; this takes 4 us when nothing is sent.
    """
    value, shown = value.astype(np.float32), getattr(node, name)
    if shown.shape != value.shape or (np.abs(shown - value) > least).any():
        setattr(node, name, value)


def srgb(linear: Colour) -> Rgb:
    """Convert a linear colour, 0 to 1, to sRGB, 0 to 255."""
    red, green, blue = (round(255 * float(np.clip(c, 0.0, 1.0)) ** (1 / 2.2)) for c in linear)
    return red, green, blue


def glb(*meshes: trimesh.Trimesh) -> bytes:
    """Return meshes with their materials as a binary glTF file."""
    made = trimesh.Scene(meshes).export(file_type="glb", include_normals=True)
    assert isinstance(made, bytes)
    return made


def wxyz(rotations: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return the (..., 4) quaternions of (..., 3, 3) rotations."""
    return SO3.from_matrix(rotations).wxyz
