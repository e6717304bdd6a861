"""Draw the clips in the field, and the clip between the applier's jaws."""

from __future__ import annotations

import numpy as np
import sapien

from tissue_sim.field import Field
from tissue_sim.frames import Array, pose
from tissue_sim.rendering.clip_shape import HALF_TURN, leg, look_of
from tissue_sim.rendering.drawing import Drawn
from tissue_sim.sensing.observation import MAX_CLIPS
from tissue_sim.surgery.clip import T_world_clip
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clips import CLIPS, ClipKind
from tissue_sim.tools.instruments import PATCH_LINKS


class DrawnClips:
    """Two legs for each clip, both on tissue and loose in the field.

    Every place in the order of the clips has the legs of each kind; those of other kinds hide.
    """

    def __init__(self, scene: sapien.Scene) -> None:
        self._legs = [
            {name: _two_legs(scene, kind) for name, kind in CLIPS.items()}
            for _ in range(MAX_CLIPS + 1)
        ]

    def update(self, field: Field) -> None:
        """Draw every clip at its current place."""
        shown = T_world_legs(field)
        for k, by_kind in enumerate(self._legs):
            kind, places = shown[k] if k < len(shown) else (None, ())
            for name, legs in by_kind.items():
                if kind is None or name != kind.name:
                    for drawn in legs:
                        drawn.hide()
                    continue
                for drawn, T in zip(legs, places, strict=True):
                    drawn.keep(leg(kind))
                    drawn.move(T)


def _two_legs(scene: sapien.Scene, kind: ClipKind) -> tuple[Drawn, Drawn]:
    return Drawn(scene, "clip", look_of(kind)), Drawn(scene, "clip", look_of(kind))


def T_world_legs(field: Field) -> list[tuple[ClipKind, tuple[Array, Array]]]:
    """Return kind and legs' poses of each clip: the latest `MAX_CLIPS`, then the loaded one."""
    clips = field.record.clips[-MAX_CLIPS:]
    places = [(clip.kind, legs_of_latched(T_world_clip(field.tubes, clip))) for clip in clips]
    loaded = field.arms.mounted[RIGHT_ARM].clip
    if field.record.clip_loaded and loaded is not None:
        places.append((loaded, _legs_of_loaded(field)))
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
