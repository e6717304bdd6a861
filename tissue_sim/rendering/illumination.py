"""The endoscope's light, which moves with it, and the light that the cavity reflects."""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import pose
from tissue_sim.sensing.cameras import looking

LAMP_W_SR = 0.028 * np.array([1.0, 0.97, 0.92])  # xenon through a fibre bundle
LAMP_BESIDE_M = np.array([-0.00225, 0.006, -0.001])  # above the eyes, between them
FILL = np.array([0.085, 0.062, 0.055])  # soft and reddish: reflected by tissue


class Illumination:
    """One lamp at the endoscope's tip and a soft fill."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._lamp = sapien.render.RenderPointLightComponent()
        self._lamp.shadow = False
        self._lamp.color = LAMP_W_SR.tolist()
        self._mount = sapien.Entity()
        self._mount.name = "lamp"
        self._mount.add_component(self._lamp)
        scene.add_entity(self._mount)
        scene.render_system.ambient_light = FILL  # pyright: ignore[reportAttributeAccessIssue]

    def update(self, field: Field) -> None:
        """Move the lamp with the endoscope."""
        T_world_lamp = field.T_world_endoscope @ pose(np.eye(3), LAMP_BESIDE_M)
        self._mount.set_pose(sapien.Pose(looking(T_world_lamp)))
