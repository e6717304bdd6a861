"""A scripted surgeon who watches a procedure, reads the truth, and corrects the robot in words.

SRT-H's surgeon watched the pictures and said one of 18 corrections where the robot erred. The
scripted surgeon says how far the right arm must move if its jaws are about to act beside their
place. It orders the jaws closed once they are in their place, and says nothing otherwise. The inbox
reads its words like any person's.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from controller.expert.targets import belongs_here, clip_pose, cut_pose
from planner.correction import CORRECTIONS, DIRECTION_ENDOSCOPE
from planner.procedure.outcomes import structure_of, task_done
from planner.procedure.task import Task
from scenarios.loop.observer import Observer
from scenarios.loop.person.inbox import Inbox
from scenarios.loop.step import Step
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array, inverse_pose
from tissue_sim.outcome.clip_rule import USUAL_CLIPS
from tissue_sim.patient.tubes import between_jaws
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

SHOWN_M = 1.5e-3  # along an axis of the endoscope: an error that a surgeon notices; assumed
LOWER_M = 3e-3  # by which the upper clip may sit lower: the gallbladder may be in the way; assumed
CONTENT_M = 1e-3  # remaining error along each axis after a correction; assumed
MOST_SAID = 6  # in a try, where the jaws would close rightly; assumed
NEAR_M = 0.010  # from the jaws' place: farther off they are on their way; assumed
CLOSING_RAD = 3e-3  # in a control step; assumed
STANDS_M, STANDS_S = 1e-3, 1.0  # a tip that has moved by less stands; assumed
AWAY = 2  # axis of the endoscope
WORDS = {c.direction or c.jaw: c.text for c in CORRECTIONS if c.arm == "right"}


class Surgeon(Observer):
    """Observes an episode, and speaks to the robot through the episode's inbox."""

    def __init__(self, inbox: Inbox) -> None:
        self._inbox = inbox

    def on_reset(self, world: World) -> None:
        """Begin to watch."""
        self._world, self._said = world, 0
        self._task: Task | None = None
        self._jaw_rad = np.inf
        self._tips_m = deque[Array](maxlen=round(STANDS_S / CONTROL_PERIOD_S))

    def on_step(self, step: Step) -> None:
        """Observe a step; say a correction if the step needs one."""
        task, closes, stands = step.instruction.task, self._closes(step), self._stands(step)
        self._said = self._said if task == self._task else 0
        self._task = task
        waits = step.exchange or step.instruction.hold or step.instruction.source == "human"
        if waits or not task.is_deed or task_done(task, self._world):
            return
        if (words := self._words(task, closes=closes, stands=stands)) is not None:
            self._said += 1
            self._inbox.say(words)

    def _closes(self, step: Step) -> bool:
        jaw_rad = float(step.command.joints[RIGHT_ARM, 6])
        closes, self._jaw_rad = jaw_rad < self._jaw_rad - CLOSING_RAD, jaw_rad
        return closes

    def _stands(self, step: Step) -> bool:
        self._tips_m.append(step.exact.tips_endoscope[RIGHT_ARM, :3, 3].copy())
        moved_m = float(np.linalg.norm(self._tips_m[-1] - self._tips_m[0]))
        return len(self._tips_m) == self._tips_m.maxlen and moved_m < STANDS_M

    def _words(self, task: Task, *, closes: bool, stands: bool) -> str | None:
        """Return the words that help now; None if there are none."""
        goal, tip_m = self._goal(task), self._world.arms.T_world_tool()[RIGHT_ARM, :3, 3]
        off_m = inverse_pose(self._world.T_world_endoscope)[:3, :3] @ (goal[:3, 3] - tip_m)
        past = off_m[AWAY] < -SHOWN_M
        if np.linalg.norm(off_m) > NEAR_M or not (closes or stands or past or self._said):
            return None
        right = self._is_right(task, low_m=float((goal[:3, 3] - tip_m) @ goal[:3, 0]))
        if right and not (self._said or stands):
            return None
        axis = int(np.abs(off_m).argmax())
        if abs(off_m[axis]) < CONTENT_M or (right and self._said >= MOST_SAID):
            return WORDS["close"] if right else WORDS["open"] if stands else None
        return f"{_way(axis, off_m[axis])} by {1e3 * abs(off_m[axis]):.1f} mm"

    def _goal(self, task: Task) -> Array:
        """Return `T_world_tool` at the task's place."""
        world, tube = self._world, structure_of(task, self._world)
        return clip_pose(world, tube, task.clip) if task.clip else cut_pose(world, tube)

    def _is_right(self, task: Task, *, low_m: float) -> bool:
        """Return whether jaws that close now, `low_m` below their place, would act correctly."""
        world, tube = self._world, structure_of(task, self._world)
        T, tool = world.arms.T_world_tool()[RIGHT_ARM], world.arms.mounted[RIGHT_ARM]
        on_tube = between_jaws(world.tubes, T, tool.name) == {tube} and belongs_here(world, tube, T)
        lowest_m = LOWER_M if task.clip == USUAL_CLIPS else SHOWN_M
        return on_tube and -SHOWN_M <= low_m <= lowest_m


def _way(axis: int, way_m: float) -> str:
    """Return the words for the right arm to move along an axis of the endoscope."""
    ways = DIRECTION_ENDOSCOPE.items()
    return WORDS[next(name for name, way in ways if way[axis] * way_m > 0.0)]
