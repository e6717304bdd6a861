"""Draw the clips in the field, and the clip between the applier's jaws."""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import Array, pose
from tissue_sim.rendering.clip_shape import HALF_TURN, LOOK, leg
from tissue_sim.rendering.drawing import Drawn
from tissue_sim.sensing.observation import MAX_CLIPS
from tissue_sim.surgery.clip import T_world_clip
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import PATCH_LINKS


class DrawnClips:
    """Two legs for each clip, both on tissue and loose in the field."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._legs = [
            (Drawn(scene, "clip", LOOK), Drawn(scene, "clip", LOOK)) for _ in range(MAX_CLIPS + 1)
        ]

    def update(self, field: Field) -> None:
        """Draw every clip at its current place."""
        places = T_world_legs(field)
        for k, legs in enumerate(self._legs):
            for side, drawn in enumerate(legs):
                if k < len(places):
                    drawn.keep(leg())
                    drawn.move(places[k][side])
                else:
                    drawn.hide()


def T_world_legs(field: Field) -> list[tuple[Array, Array]]:
    """Return the poses of both legs of each clip: the latest `MAX_CLIPS`, then the loaded one."""
    clips = field.record.clips[-MAX_CLIPS:]
    places = [legs_of_latched(T_world_clip(field.tubes, clip)) for clip in clips]
    if field.record.clip_loaded and field.arms.mounted[RIGHT_ARM].deed == "clip":
        places.append(_legs_of_loaded(field))
    return places


def legs_of_latched(T_world_clip: Array) -> tuple[Array, Array]:
    """Return the poses of both legs of a closed clip."""
    return T_world_clip, T_world_clip @ HALF_TURN


def _legs_of_loaded(field: Field) -> tuple[Array, Array]:
    """Return the poses of both legs in the grooves of the applier's fingers."""
    T_world_link = field.arms.contact_shapes().T_world_link
    first = RIGHT_ARM * len(PATCH_LINKS) + PATCH_LINKS.index("finger_plus")
    tip = pose(np.eye(3), np.array([0.0, 0.0, field.arms.mounted[RIGHT_ARM].yaw_to_tip_m]))
    return T_world_link[first] @ tip, T_world_link[first + 1] @ tip @ HALF_TURN
