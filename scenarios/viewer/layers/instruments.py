"""Both arms' instruments, link by link."""

from __future__ import annotations

import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import glb, wxyz
from tissue_sim.arms import LEFT_ARM, RIGHT_ARM
from tissue_sim.frames import Array, inverse_pose
from tissue_sim.instrument_meshes import finished, link_parts
from tissue_sim.instruments import INSTRUMENTS, PATCH_LINKS, Instrument
from tissue_sim.psm import T_yaw_tool

ARM_OF = {"grasper": LEFT_ARM, "clip_applier": RIGHT_ARM, "scissors": RIGHT_ARM}


class InstrumentLayer:
    """All three tools from the start; what is not mounted is hidden."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        del patient
        self._links = {
            (tool, link): scene.add_glb(f"{root}/{tool}/{link}", mesh, visible=False)
            for tool, instrument in INSTRUMENTS.items()
            for link, mesh in _glbs(instrument).items()
        }

    def update(self, frame: Frame) -> None:
        """Put every link of the mounted tools where it is."""
        for (tool, link), node in self._links.items():
            arm = ARM_OF[tool]
            mounted = frame.tools[arm] == tool
            node.visible = mounted
            if mounted:
                T = _T_world_link(frame, arm, link)
                node.position, node.wxyz = T[:3, 3], wxyz(T[:3, :3])


def _glbs(instrument: Instrument) -> dict[str, bytes]:
    return {
        link: glb(*(finished(part) for part in parts))
        for link, parts in link_parts(instrument).items()
    }


def _T_world_link(frame: Frame, arm: int, link: str) -> Array:
    """The palm touches nothing, so it is not among the links whose poses tissue knows."""
    if link in PATCH_LINKS:
        return frame.T_world_link[arm, PATCH_LINKS.index(link)]
    return frame.T_world_tool[arm] @ inverse_pose(T_yaw_tool(INSTRUMENTS[frame.tools[arm]]))
