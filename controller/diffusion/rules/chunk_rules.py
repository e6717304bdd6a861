"""Apply the rules that change a chunk after the network, in their order, and count their use."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.rules.centring import centre_on_place
from controller.diffusion.rules.closing import close_in_place
from controller.diffusion.rules.grasping import complete_grasp
from controller.diffusion.rules.holding import hold_still, rest_right_arm
from controller.diffusion.rules.reaching import reach_place
from controller.diffusion.rules.retreating import retract
from controller.diffusion.rules.squaring import square_grasper
from controller.diffusion.rules.unhooking import unhook_grasper
from controller.diffusion.scene.scene import Scene
from planner.procedure.task import Task
from planner.rules.rule_use import ANY, RuleCounts, RuleUse
from tissue_sim.frames import Array

Rule = Callable[[Array, Scene, Task, Array], Array]
"""Returns a chunk (n, 20), by four arguments.

chunk: The chunk, in the form of `chunk_frame`; it is unchanged.
scene: The scene at the chunk's start.
task: The running task.
commanded: (m, 2) jaw angles commanded before the chunk, the newest last.
"""

RULES: dict[str, Rule] = {
    "hold-still": hold_still,
    "square-grasper": square_grasper,
    "complete-grasp": complete_grasp,
    "rest-right-arm": rest_right_arm,
    "reach-place": reach_place,
    "centre-on-place": centre_on_place,
    "retract": retract,
    "close-in-place": close_in_place,
    "unhook-grasper": unhook_grasper,
}
"""The rules by name, in the order in which they are applied."""

ALSO_CORRECTED = ("hold-still", "unhook-grasper")
"""Rules that also apply while a correction is in force: retracting may catch on tissue, too."""


class ChunkRules:
    """Applies the rules to chunks, without some of them, and counts what they change."""

    def __init__(self, without: Collection[str] = ()) -> None:
        self._rules = {name: rule for name, rule in RULES.items() if name not in without}
        self._counts = RuleCounts("controller", self._rules)

    def apply(self, chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
        """Return a chunk (n, 20) with the changes of all rules that apply, as a `Rule` does."""
        asked = chunk
        for name, rule in self._rules.items():
            if scene.is_corrected and name not in ALSO_CORRECTED:
                continue
            before, chunk = chunk, rule(chunk, scene, task, commanded)
            self._note(name, before, chunk)
        self._note(ANY, asked, chunk)
        return chunk

    def uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule so far; nothing if all rules are left out."""
        return self._counts.uses() if self._rules else ()

    def _note(self, name: str, before: Array, after: Array) -> None:
        if after is before or np.array_equal(before, after):
            self._counts.note(name, changed=False)
            return
        change = np.abs((after - before).reshape(len(before), 2, -1))
        self._counts.note(
            name,
            changed=True,
            moved_m=float(np.linalg.norm(change[..., MOVE], axis=-1).max()),
            jaw_rad=float(change[..., JAW].max()),
        )
