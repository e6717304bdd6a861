"""Define the cameras of a field, and the objects that they show.

The objects are updated only when a picture is requested. Nothing here changes the field: a run with
pictures equals the run without them, bit for bit.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array
from tissue_sim.rendering.drawn_bed import DrawnBed
from tissue_sim.rendering.drawn_clips import DrawnClips
from tissue_sim.rendering.drawn_fat import DrawnFat
from tissue_sim.rendering.drawn_leaks import DrawnLeaks
from tissue_sim.rendering.drawn_ligament import DrawnLigament
from tissue_sim.rendering.drawn_strands import DrawnStrands
from tissue_sim.rendering.drawn_surroundings import DrawnAssistant, DrawnSurroundings
from tissue_sim.rendering.drawn_tissue import DrawnTissue
from tissue_sim.rendering.illumination import Illumination
from tissue_sim.rendering.renderer import render_system
from tissue_sim.rendering.shader_pack import (
    COLOR_PICTURE,
    POSITION_PICTURE,
    set_picture_formats,
    shader_pack,
)
from tissue_sim.sensing.cameras import (
    CAMERAS,
    FAR_PLANE_M,
    NEAR_PLANE_M,
    CameraSpec,
    T_world_camera,
)
from tissue_sim.tools.drives import physics_system

# what cameras show; `update` draws an object in the field's current state
VISUALS = (
    DrawnSurroundings,
    DrawnAssistant,
    DrawnBed,
    DrawnLigament,
    DrawnFat,
    DrawnTissue,
    DrawnStrands,
    DrawnClips,
    DrawnLeaks,
    Illumination,
)


def renderable_scene() -> sapien.Scene:
    """Make an empty scene with physics and a renderer, on a GPU if there is one."""
    return sapien.Scene([physics_system(), render_system()])


class FieldCameras:
    """All cameras on one field's scene."""

    def __init__(self, scene: sapien.Scene, cameras: Sequence[CameraSpec] = CAMERAS) -> None:
        self._scene = scene
        self._specs = {spec.name: spec for spec in cameras}
        self._cameras: dict[CameraSpec, sapien.render.RenderCameraComponent] = {}
        self._visuals = [visual(scene) for visual in VISUALS]

    def update(self, field: Field) -> None:
        """Draw all objects in the field's current state."""
        for visual in self._visuals:
            visual.update(field)

    def images(self, field: Field, names: Iterable[str]) -> dict[str, NDArray[np.uint8]]:
        """Take the cameras' pictures now: camera name -> (height, width, 3) uint8.

        Raises:
            ValueError: there is no such camera.
        """
        return self.pictures(field, [self._spec(name) for name in names])[COLOR_PICTURE]

    def pictures(
        self,
        field: Field,
        specs: Sequence[CameraSpec],
        kinds: Sequence[str] = (COLOR_PICTURE,),
        aims_m: Mapping[str, Array] | None = None,
    ) -> dict[str, dict[str, NDArray]]:
        """Take pictures of any cameras now: kind -> camera name -> picture (height, width, ...).

        Args:
            field: The field to draw.
            specs: The cameras.
            kinds: `COLOR_PICTURE`, here without its fourth channel, and `POSITION_PICTURE`.
            aims_m: Points of the world at which crops are aimed, by camera name.
        """
        cameras = {spec.name: self._camera(spec) for spec in specs}
        self.update(field)
        for name, camera in cameras.items():
            T = T_world_camera(field, name, (aims_m or {}).get(name))
            camera.entity.set_pose(sapien.Pose(T))
        self._scene.update_render()
        for camera in cameras.values():
            camera.take_picture()
        channels = {COLOR_PICTURE: 3, POSITION_PICTURE: 4}
        return {
            kind: {n: c.get_picture(kind)[..., : channels[kind]] for n, c in cameras.items()}
            for kind in kinds
        }

    def _spec(self, name: str) -> CameraSpec:
        if name not in self._specs:
            raise ValueError(f"no camera {name!r}: choose from {sorted(self._specs)}")
        return self._specs[name]

    def _camera(self, spec: CameraSpec) -> sapien.render.RenderCameraComponent:
        if spec not in self._cameras:
            self._cameras[spec] = _add_camera(self._scene, spec)
        return self._cameras[spec]


def _add_camera(scene: sapien.Scene, spec: CameraSpec) -> sapien.render.RenderCameraComponent:
    set_picture_formats()
    camera = sapien.render.RenderCameraComponent(spec.width, spec.height, str(shader_pack()))
    camera.set_fovy(spec.fov_rad, compute_x=True)
    camera.near, camera.far = NEAR_PLANE_M, FAR_PLANE_M
    entity = sapien.Entity()
    entity.name = spec.name
    entity.add_component(camera)
    scene.add_entity(entity)
    return camera
