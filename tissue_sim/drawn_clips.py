"""The clips in the field, and the one that waits between the applier's jaws."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import sapien

from tissue_sim.arms import RIGHT_ARM
from tissue_sim.clip import Clip
from tissue_sim.clip_shape import HALF_TURN, LOOK, leg
from tissue_sim.drawing import Drawn
from tissue_sim.frames import Array, pose, unit
from tissue_sim.instruments import PATCH_LINKS
from tissue_sim.observation import MOST_CLIPS

if TYPE_CHECKING:
    from tissue_sim.world import World

HINT_SHARE = 0.1


class DrawnClips:
    """Two legs a clip; one that caught nothing or was lost is not drawn."""

    def __init__(self, scene: sapien.Scene) -> None:
        self._legs = [
            (Drawn(scene, "clip", LOOK), Drawn(scene, "clip", LOOK)) for _ in range(MOST_CLIPS + 1)
        ]

    def update(self, world: World) -> None:
        """Draw every clip where it is."""
        held = [c for c in world.record.clips if c.vertices and not c.lost][-MOST_CLIPS:]
        places = [legs_of_latched(T_world_clip(world, clip)) for clip in held]
        if world.record.clip_loaded and world.arms.mounted[RIGHT_ARM].name == "clip_applier":
            places.append(_legs_of_loaded(world))
        for k, legs in enumerate(self._legs):
            for side, drawn in enumerate(legs):
                if k < len(places):
                    drawn.keep(leg())
                    drawn.move(places[k][side])
                else:
                    drawn.hide()


def T_world_clip(world: World, clip: Clip) -> Array:
    """Where a clip is now (4, 4), from the tissue it holds.

    It stands square to the tube, its legs along the flattened section's width.
    """
    crossing = clip.crossings[0]
    point, tangent = world.tubes.point(crossing.tube, crossing.station_m)
    x_closed, _, z_closed = clip.T_world_clip[:3, :3].T
    along = tangent if tangent @ x_closed > 0 else -tangent
    section = world.tissue.positions()[list(clip.vertices)].astype(float)
    legs = _widest(section - section.mean(axis=0), along, z_closed)
    axes = np.stack([along, np.cross(legs, along), legs], axis=1)
    beside = crossing.point_m * np.array([0.0, 0.0, 1.0])  # the legs close on the tube's middle
    return pose(axes, point - axes @ beside)


def _widest(offsets: Array, along: Array, hint: Array) -> Array:
    """The direction (3,) across `along` in which the offsets (n, 3) spread most.

    A section that is still round has none: then the hint decides, and always its sign.
    """
    across = np.eye(3) - np.outer(along, along)
    spread = across @ (offsets.T @ offsets) @ across
    hint = unit(across @ hint)
    tensor = spread / np.trace(spread) + HINT_SHARE * np.outer(hint, hint)
    widest = np.linalg.eigh(tensor)[1][:, -1]
    return widest if widest @ hint > 0 else -widest


def legs_of_latched(T_world_clip: Array) -> tuple[Array, Array]:
    """Poses of both legs of a closed clip."""
    return T_world_clip, T_world_clip @ HALF_TURN


def _legs_of_loaded(world: World) -> tuple[Array, Array]:
    """Poses of both legs in the grooves of the applier's fingers."""
    T_world_link = world.arms.contact_shapes().T_world_link
    first = RIGHT_ARM * len(PATCH_LINKS) + PATCH_LINKS.index("finger_plus")
    tip = pose(np.eye(3), np.array([0.0, 0.0, world.arms.mounted[RIGHT_ARM].yaw_to_tip_m]))
    return T_world_link[first] @ tip, T_world_link[first + 1] @ tip @ HALF_TURN
