"""Layers of both arms' instruments, link by link, and of the clips."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import SEEN_TURN, glb, show, srgb, wxyz
from tissue_sim.frames import Array, inverse_pose
from tissue_sim.rendering.clip_shape import leg, look_of
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.tools.clips import CLIPS
from tissue_sim.tools.instrument_meshes import link_parts, with_finish
from tissue_sim.tools.instruments import INSTRUMENTS, PATCH_LINKS
from tissue_sim.tools.psm import T_yaw_tool

LINKS = (*PATCH_LINKS, "palm")
ARMS = {"left": LEFT_ARM, "right": RIGHT_ARM}


class InstrumentLayer:
    """All tools, created once; tools that are not mounted are hidden.

    Links are batches of one. Setting a plain node's pose takes viser longer than everything else in
    this layer.
    """

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        still, here = np.array([[1.0, 0.0, 0.0, 0.0]]), np.zeros((1, 3))
        self._links = {
            tool: {
                link: scene.add_batched_glb(
                    f"{root}/{tool}/{link}", glb(*map(with_finish, parts)), still, here, lod="off"
                )
                for link, parts in link_parts(instrument).items()
            }
            for tool, instrument in INSTRUMENTS.items()
        }

    def update(self, frame: Frame) -> None:
        """Move every link of the mounted tools to its pose."""
        T = _T_world_links(frame)
        positions, turns = T[..., :3, 3], wxyz(T[..., :3, :3])
        for tool, links in self._links.items():
            arm = ARMS[INSTRUMENTS[tool].arm]
            mounted = frame.tools[arm] == tool
            for k, link in enumerate(LINKS):
                if links[link].visible != mounted:
                    links[link].visible = mounted
                if mounted:
                    show(links[link], "batched_positions", positions[arm, k : k + 1])
                    show(links[link], "batched_wxyzs", turns[arm, k : k + 1], SEEN_TURN)


def _T_world_links(frame: Frame) -> Array:
    """Return (2, 5, 4, 4) poses of the links; the palm's is computed from the tool's."""
    tools = [INSTRUMENTS[name] for name in frame.tools]
    palms = frame.T_world_tool @ np.stack([inverse_pose(T_yaw_tool(tool)) for tool in tools])
    return np.concatenate([frame.T_world_link, palms[:, None]], axis=1)


class ClipLayer:
    """The clips on tissue, loose in the field, and in the applier.

    One mesh for each kind, the leg of a clip, is drawn at many poses.
    """

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._legs = {
            name: scene.add_batched_meshes_simple(
                f"{root}/clips/{name}",
                np.asarray(leg(kind).points, np.float32),
                np.asarray(leg(kind).triangles, np.uint32),
                batched_wxyzs=np.zeros((0, 4)),
                batched_positions=np.zeros((0, 3)),
                batched_colors=srgb(look_of(kind).colour),
                flat_shading=True,
                lod="off",
            )
            for name, kind in CLIPS.items()
        }

    def update(self, frame: Frame) -> None:
        """Move the legs to their poses."""
        kinds = np.array(frame.leg_kinds)
        for name, legs in self._legs.items():
            T = frame.T_world_leg[kinds == name]
            show(legs, "batched_positions", T[:, :3, 3])
            show(legs, "batched_wxyzs", wxyz(T[:, :3, :3]), SEEN_TURN)
