"""Define a task: one step of a procedure."""

from __future__ import annotations

from dataclasses import dataclass

from planner.procedure.task_kind import KINDS, Deed, TaskKind, entry_of
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.patient.tube_names import OPTIONAL_TUBES, TUBES, Tube
from tissue_sim.tools.instruments import INSTRUMENTS, right_tools

CLIP_NUMBERS = tuple(range(1, USUAL_CLIPS + 1))  # on a tube


@dataclass(frozen=True, kw_only=True)
class Task:
    """One step of a procedure.

    Attributes:
        index: Place in the procedure, from 1.
        text: The words of a surgeon, unique to the task.
        kind: Kind of the task, a key of `planner.procedure.task_kind.KINDS`.
        tube: The tube of the task, as the endoscope shows it; None for a task on no tube. Only a
            patient with a second artery has the third tube.
        clip: Number of the clip on the tube, 1 to 3; None if the task has no clip.
        right_tool: The tool that the right arm must hold, a key of
            `tissue_sim.tools.instruments.INSTRUMENTS`; the left arm always holds the grasper.
    """

    index: int
    text: str
    kind: str
    tube: Tube | None = None
    clip: int | None = None
    right_tool: str

    @property
    def fault(self) -> str:
        """Return in words why nobody can carry out the task; "" if nothing stands against it."""
        tools = {name: INSTRUMENTS[name].deed for name in right_tools()}
        if not isinstance(self.text, str) or not self.text.strip() or not self.text.isprintable():
            return f"{self.text!r} is no line of words"
        if self.kind not in KINDS:
            return f"unknown kind {self.kind!r}; allowed: {', '.join(KINDS)}"
        if self.right_tool not in tools:
            return f"no {self.right_tool!r} for the right arm; allowed: {', '.join(tools)}"
        if self.tube not in (None, *TUBES):
            return f"unknown tube {self.tube!r}; allowed: {', '.join(TUBES)}, None"
        if self.is_deed and (self.tube is None or tools[self.right_tool] != self.deed):
            able = ", ".join(name for name, deed in tools.items() if deed == self.deed)
            return f"to {self.deed}, it needs a tube, and one of these tools: {able}"
        numbers = CLIP_NUMBERS if self.places_clip else (None, *CLIP_NUMBERS)
        if self.clip not in numbers:
            return f"unknown clip {self.clip!r}; allowed: {', '.join(map(str, numbers))}"
        return ""

    @property
    def traits(self) -> TaskKind:
        """Return what tasks of this kind do."""
        return entry_of(self.kind, KINDS, "KINDS")

    @property
    def is_optional(self) -> bool:
        """Return whether the task belongs only to patients that have its tube."""
        return self.tube in OPTIONAL_TUBES

    @property
    def grasps(self) -> bool:
        """Return whether the left arm takes hold of the gallbladder."""
        return self.traits.grasps

    @property
    def goes_back(self) -> bool:
        """Return whether the right arm only retracts, from a clip or from the cut."""
        return self.traits.goes_back

    @property
    def deed(self) -> Deed | None:
        """Return what the right tool does to tissue for good: "clip" or "cut"; else None."""
        return self.traits.deed

    @property
    def is_deed(self) -> bool:
        """Return whether the task is a clip or a cut, which cannot be undone."""
        return self.deed is not None

    @property
    def places_clip(self) -> bool:
        """Return whether the task needs a loaded applier, and places its clip."""
        return self.deed == "clip"

    @property
    def severs(self) -> bool:
        """Return whether the task cuts its tube."""
        return self.deed == "cut"
