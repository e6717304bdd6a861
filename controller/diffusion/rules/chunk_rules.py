"""The rules that change a chunk after the network, in their order, and a record of their use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from controller.diffusion.chunk_frame import JAW, MOVE
from controller.diffusion.rules.centring import centre_on_place
from controller.diffusion.rules.closing import close_in_place
from controller.diffusion.rules.grasping import complete_grasp
from controller.diffusion.rules.holding import hold_still
from controller.diffusion.rules.reaching import reach_place
from controller.diffusion.rules.retreating import retract
from controller.diffusion.rules.squaring import square_grasper
from controller.diffusion.rules.unhooking import unhook_grasper
from controller.diffusion.rules.waiting import rest_right_arm
from controller.diffusion.scene.scene import Scene
from planner.rules.rule_use import RuleUse
from planner.task import Task
from tissue_sim.frames import Array

Rule = Callable[[Array, Scene, Task, Array], Array]

RULES: dict[str, Rule] = {
    "hold still": hold_still,
    "square grasper": square_grasper,
    "complete grasp": complete_grasp,
    "rest right arm": rest_right_arm,
    "reach place": reach_place,
    "centre on place": centre_on_place,
    "retract": retract,
    "close in place": close_in_place,
    "unhook grasper": unhook_grasper,
}
"""By name, in the order in which they are applied."""

ALSO_CORRECTED = ("hold still", "unhook grasper")
"""Rules that also apply while a correction is in force: retracting may catch on tissue, too."""


@dataclass
class _Use:
    """Counts of one rule's use; the attributes are those of `RuleUse`."""

    decisions: int = 0
    changed: int = 0
    most_m: float = 0.0
    most_rad: float = 0.0

    def note(self, before: Array, after: Array) -> None:
        """Add a chunk (n, 20) before and after the rule."""
        self.decisions += 1
        if after is before or np.array_equal(before, after):
            return
        change = np.abs((after - before).reshape(len(before), 2, -1))
        self.changed += 1
        self.most_m = max(self.most_m, float(np.linalg.norm(change[..., MOVE], axis=-1).max()))
        self.most_rad = max(self.most_rad, float(change[..., JAW].max()))


class ChunkRules:
    """Applies the rules to chunks and counts what they change."""

    def __init__(self) -> None:
        self._uses = {name: _Use() for name in RULES}

    def apply(self, chunk: Array, scene: Scene, task: Task, commanded: Array) -> Array:
        """Return a chunk (n, 20) with the changes of all rules that apply.

        Args:
            chunk: as `chunk_frame` has it; not changed.
            scene: at its start.
            task: the running one.
            commanded: jaw angles (m, 2) before it, the last ones last.
        """
        for name, rule in RULES.items():
            if scene.is_corrected and name not in ALSO_CORRECTED:
                continue
            before, chunk = chunk, rule(chunk, scene, task, commanded)
            self._uses[name].note(before, chunk)
        return chunk

    def uses(self) -> tuple[RuleUse, ...]:
        """Return the use of each rule so far."""
        return tuple(
            RuleUse(
                policy="controller",
                rule=name,
                decisions=use.decisions,
                changed=use.changed,
                most_m=use.most_m,
                most_rad=use.most_rad,
            )
            for name, use in self._uses.items()
        )
