"""Layers of the rigid surroundings (liver, fat and abdominal wall) and of the endoscope's light."""

from __future__ import annotations

from dataclasses import replace
from io import BytesIO

import numpy as np
import trimesh
import viser
from PIL import Image
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import Rgb, glb, show
from tissue_sim.frames import Array, pose
from tissue_sim.rendering.drawing import Surface
from tissue_sim.rendering.drawn_surroundings import surroundings
from tissue_sim.rendering.illumination import LAMP_BESIDE_M
from tissue_sim.rendering.textures import BLURRED_RELIEF, Look, colours, relief

CAVITY = "cavity"
XENON: Rgb = (255, 247, 235)
INTENSITY_CD = 0.02  # assumed: looks like the renderer's picture
FILL = 0.12  # intensity of viser's "studio" light from all sides


class SurroundingsLayer:
    """The rigid surroundings inside the cavity, which move with the body."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._body = scene.add_frame(f"{root}/body", show_axes=False)
        for name, (surface, look) in surroundings(patient.organ, patient.anatomy).items():
            if name != CAVITY:
                scene.add_glb(f"{root}/body/{name}", _glb(surface, look), cast_shadow=False)

    def update(self, frame: Frame) -> None:
        """Move the surroundings with the body."""
        show(self._body, "position", frame.body_m)


class CavityLayer:
    """The abdominal wall, seen from inside."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        surface, look = surroundings(patient.organ, patient.anatomy)[CAVITY]
        scene.add_glb(f"{root}/wall", _glb(surface, look), cast_shadow=False)

    def update(self, frame: Frame) -> None:
        """Do nothing: the wall does not move."""


class LampLayer:
    """A lamp at the endoscope's tip, and a weak light from all sides."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        scene.configure_default_lights(enabled=False)
        scene.configure_environment_map("studio", environment_intensity=FILL)
        self._lamp = scene.add_light_point(f"{root}/lamp", color=XENON, intensity=INTENSITY_CD)

    def update(self, frame: Frame) -> None:
        """Move the lamp with the endoscope."""
        lamp = frame.T_world_endoscope @ pose(np.eye(3), LAMP_BESIDE_M)
        show(self._lamp, "position", lamp[:3, 3])


def _glb(surface: Surface, look: Look) -> bytes:
    material = PBRMaterial(
        baseColorTexture=_picture(np.clip(colours(look), 0.0, 1.0) ** (1 / 2.2)),
        normalTexture=_picture(relief(_dry(look))) if look.relief else None,
        metallicFactor=0.0,
        roughnessFactor=look.roughness,
    )
    mesh = trimesh.Trimesh(
        vertices=surface.points,
        faces=surface.triangles,
        vertex_normals=surface.normals,
        visual=TextureVisuals(uv=surface.uv, material=material),
        process=False,
    )
    return glb(mesh)


def _dry(look: Look) -> Look:
    """Return the tissue without its film, which the page does not draw."""
    return replace(look, relief=BLURRED_RELIEF * look.relief, lobules=BLURRED_RELIEF * look.lobules)


def _picture(values: Array) -> Image.Image:
    """Convert (size, size, 3) values of 0 to 1 to a JPEG, a tenth the size of a PNG."""
    sink = BytesIO()
    Image.fromarray(np.round(255 * values).astype(np.uint8)).save(sink, "JPEG", quality=85)
    return Image.open(sink)
