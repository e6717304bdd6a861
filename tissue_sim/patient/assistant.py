"""Place the assistant's grasper, which holds the fundus of the gallbladder over the liver.

The assistant does not move it during the procedure. The instrument has its own port, above the
robot's ports and on the left in the picture, so its shaft leaves the field upwards. It moves with
the body as the liver does, because the assistant's hand follows the breath. Drawing, simulator and
safety filter use the same line.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tissue_sim.frames import Array, field_point, pose, unit
from tissue_sim.patient.organ import Organ

# Assumed: on the abdominal wall, as the robot's ports (`tissue_sim.tools.arms`), but higher.
PORT_M = field_point(-0.080, 0.200, -0.058)
SHAFT_RADIUS_M = 0.0025  # a laparoscopic instrument of 5 mm
JAWS_M = 0.016  # assumed: length of the jaws, which lie on the fundus
BITE_M = 0.002  # assumed: depth of the jaws' tips inside the fundus' surface


@dataclass(frozen=True, kw_only=True)
class Assistant:
    """The assistant's instrument at rest, world frame.

    Attributes:
        tip_m: (3,) tips of the jaws, in the fundus.
        port_m: (3,) where the shaft leaves the body.
    """

    tip_m: Array
    port_m: Array

    @property
    def back(self) -> Array:
        """Return the unit vector (3,) from the tips to the port."""
        return unit(self.port_m - self.tip_m)

    @property
    def pivot_m(self) -> Array:
        """Return the foremost point of the shaft (3,), where the jaws begin."""
        return self.tip_m + JAWS_M * self.back


def assistant_of(organ: Organ) -> Assistant:
    """Return the instrument that holds this gallbladder's fundus."""
    last = organ.vertices[organ.sac_rings[-1]]
    outward = (last - last[0]) @ unit(PORT_M - last[0])
    tip_m = last[0] + max(outward.max() - BITE_M, 0.0) * unit(PORT_M - last[0])
    return Assistant(tip_m=tip_m, port_m=PORT_M)


def T_world_shaft(assistant: Assistant) -> Array:
    """Return the pose (4, 4) of the shaft's middle, with +x along the shaft to the port."""
    x = assistant.back
    y = unit(np.cross([0.0, 1.0, 0.0], x))
    axes = np.stack([x, y, np.cross(x, y)], axis=1)
    return pose(axes, 0.5 * (assistant.pivot_m + assistant.port_m))


def shaft_length_m(assistant: Assistant) -> float:
    """Return the length of the shaft from the jaws to the port."""
    return float(np.linalg.norm(assistant.port_m - assistant.pivot_m))
