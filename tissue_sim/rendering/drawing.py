"""Draw a triangle surface in a SAPIEN scene; the surface may move or change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.rendering.textures import Look, material


@dataclass(frozen=True, kw_only=True)
class Surface:
    """A closed or open triangle surface.

    Attributes:
        points: (n, 3), m.
        normals: (n, 3), unit.
        triangles: (n_triangle, 3), visible from the side on which they run counter-clockwise.
        uv: (n, 2) texture coordinates; zeros without a texture.
    """

    points: NDArray[np.floating]
    normals: NDArray[np.floating]
    triangles: NDArray[np.integer]
    uv: NDArray[np.floating]


class Drawn:
    """One named entity in the scene, for cameras only, without part in the physics."""

    def __init__(
        self, scene: sapien.Scene, name: str, look: Look | sapien.render.RenderMaterial
    ) -> None:
        self._scene = scene
        self._material = material(look) if isinstance(look, Look) else look
        self._component: sapien.render.RenderBodyComponent | None = None
        self.entity = sapien.Entity()
        self.entity.name = name
        scene.add_entity(self.entity)

    def show(self, surface: Surface) -> None:
        """Draw this surface from now on. A new mesh replaces the old one: meshes cannot change."""
        component = sapien.render.RenderBodyComponent()
        component.attach(
            sapien.render.RenderShapeTriangleMesh(
                np.ascontiguousarray(surface.points, np.float32),
                np.ascontiguousarray(surface.triangles, np.uint32),
                np.ascontiguousarray(surface.normals, np.float32),
                np.ascontiguousarray(surface.uv, np.float32),
                self._material,
            )
        )
        self.hide()
        self.entity.add_component(component)
        self._component = component

    def keep(self, surface: Surface) -> None:
        """Draw this surface if none is drawn yet; use this for shapes that only move."""
        if self._component is None:
            self.show(surface)

    def hide(self) -> None:
        """Draw nothing until the next `show`."""
        if self._component is not None:
            self.entity.remove_component(self._component)
            self._component = None

    def move(self, T_world_surface: Array) -> None:
        """Place the surface's frame in the world."""
        self.entity.set_pose(sapien.Pose(T_world_surface))

    def remove(self) -> None:
        """Remove the entity from the scene."""
        self._scene.remove_entity(self.entity)
