"""Choose the right tool for a task, as a scrub nurse does: an applier by the tube's seen width.

A task that clips names any applier. The smallest kind of clip for the tube's width is chosen when
the tube's first clip is due, and stays: noise of the observation never makes the tools alternate.
"""

from __future__ import annotations

from planner.procedure.task import Task
from planner.scene.next_task import applier_on
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.instruments import INSTRUMENTS


class ToolChoice:
    """The tools of one patient's tasks.

    Attributes:
        appliers: Name of the applier of each tube whose first clip was due.
    """

    def __init__(self) -> None:
        self.appliers: dict[str, str] = {}

    def tool(self, task: Task, observation: Observation) -> str:
        """Return the name of the tool for a task.

        A task without a clip takes the mounted tool if that can do the same.
        """
        mounted = observation.right_instrument
        if not task.places_clip or task.tube is None:
            same = mounted.deed == INSTRUMENTS[task.right_tool].deed
            return mounted.name if same else task.right_tool
        if task.tube not in self.appliers:
            self.appliers[task.tube] = applier_on(task.tube, observation).name
        return self.appliers[task.tube]
