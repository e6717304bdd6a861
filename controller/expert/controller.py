"""Run the expert, a controller that solves every task from the world's hidden state. Privileged.

The expert makes the demonstrations and is the reference for learned controllers.
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from controller.action import Chunk
from controller.expert.corrections import correcting
from controller.expert.line_errors import line_errors
from controller.expert.motion import Goal, chunk_towards
from controller.expert.phase import Phase, TaskAttempt
from controller.expert.skills import lacks_clip, skill
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup, privileged
from planner.procedure.task import Task
from tissue_sim.frames import Array
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

if TYPE_CHECKING:
    from tissue_sim.world import World


class ControllerExpert:
    """Runs the skill of the instructed task, phase by phase; the idle arm holds still.

    A correction comes first; after the correction the skill starts again.
    """

    privileged = True

    def __init__(self, world: World) -> None:
        self._world = world
        self._attempts: Counter[Task] = Counter()
        self._task: Task | None = None
        self.reset()

    def reset(self) -> None:
        """Start the current task's skill again; the jaws stay as last commanded.

        An attempt that ends here does not count as failed.
        """
        self._jaw_rad: Array = self._world.target[:, 6]
        self._interrupt()
        self._lacks_clip = False

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return a tenth of a second of motion."""
        if instruction.correction is not None:
            self._interrupt()
            goals = correcting(instruction, self._world)
        else:
            goals = self._working(instruction.task, observation)
        chunk = chunk_towards(
            goals,
            self._world.arms.T_world_tool(),
            self._jaw_rad,
            self._world.T_world_endoscope[:3, :3],
            self._world.body.velocity_m_s,
        )
        self._jaw_rad = chunk[-1].jaw_rad
        return chunk

    def _working(self, task: Task, observation: Observation) -> tuple[Goal, Goal]:
        if task != self._task or lacks_clip(task, self._world) != self._lacks_clip:
            self._begin(task, observation)
        while self._phase.done(self._world, observation.time_s - self._since_s):
            self._enter(self._at + 1, observation)
        goals = [Goal(), Goal()]
        goals[self._phase.arm] = self._phase.goal(self._world, self._start)
        return goals[LEFT_ARM], goals[RIGHT_ARM]

    def _interrupt(self) -> None:
        """End the current attempt without counting it; the next attempt repeats the approach."""
        if self._task is not None:
            self._attempts[self._task] -= 1
            self._task = None

    @property
    def _phase(self) -> Phase:
        return self._phases[self._at]

    def _begin(self, task: Task, observation: Observation) -> None:
        self._task, self._lacks_clip = task, lacks_clip(task, self._world)
        errors = line_errors(self._world, observation)
        attempt = TaskAttempt(number=self._attempts[task], errors=errors)
        self._phases = skill(task, self._world, attempt)
        self._attempts[task] += 1
        self._enter(0, observation)

    def _enter(self, at: int, observation: Observation) -> None:
        self._at = at
        self._since_s = observation.time_s
        self._start: Array = self._world.arms.T_world_tool()[self._phases[at].arm]


@privileged
def make(setup: PolicySetup, world: World) -> ControllerExpert:
    """Return the expert, which does not use its setup."""
    del setup
    return ControllerExpert(world)
