"""Light the field with the lamps of endoscope and wrists, and with the cavity's reflected light."""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import pose
from tissue_sim.sensing.cameras import T_world_camera, looking
from tissue_sim.sensing.glance import CAMERA_NAMES

LAMP_W_SR = 0.028 * np.array([1.0, 0.97, 0.92])  # xenon through a fibre bundle
LAMP_BESIDE_M = np.array([-0.00225, 0.006, -0.001])  # above the eyes, between them
WRIST_LAMP_SHARE = (
    0.02  # of the endoscope's: assumed, as in small borescopes; sufficient at short range
)
FILL = np.array([0.085, 0.062, 0.055])  # soft and reddish: reflected by tissue


class Illumination:
    """One lamp at the endoscope's tip, a small lamp at each wrist's camera, and a soft fill light.

    The endoscope's lamp comes first, because the film of liquid mirrors the first lamp alone
    (`shader_pack`).
    """

    def __init__(self, scene: sapien.Scene) -> None:
        self._endoscope = _lamp(scene, "lamp", 1.0)
        self._wrists = {n: _lamp(scene, f"lamp:{n}", WRIST_LAMP_SHARE) for n in CAMERA_NAMES[2:]}
        scene.render_system.ambient_light = FILL  # pyright: ignore[reportAttributeAccessIssue]

    def update(self, field: Field) -> None:
        """Move the lamps with endoscope and wrists."""
        T_world_lamp = field.T_world_endoscope @ pose(np.eye(3), LAMP_BESIDE_M)
        self._endoscope.set_pose(sapien.Pose(looking(T_world_lamp)))
        for name, lamp in self._wrists.items():
            lamp.set_pose(sapien.Pose(T_world_camera(field, name)))


def _lamp(scene: sapien.Scene, name: str, share: float) -> sapien.Entity:
    """Add a lamp with this share of the endoscope's brightness."""
    light = sapien.render.RenderPointLightComponent()
    light.shadow = False
    light.color = (share * LAMP_W_SR).tolist()
    mount = sapien.Entity()
    mount.name = name
    mount.add_component(light)
    scene.add_entity(mount)
    return mount
