"""A learned controller and the expert in turns: the data shows how to act in a learner's states.

After HG-DAgger (Kelly et al., arXiv 1810.02890): only the expert's motions are imitated. Here the
expert takes over when a task takes long, until the next one begins, and at random times.
"""

from __future__ import annotations

import numpy as np

from controller.action import Chunk
from controller.base import Controller
from planner.instruction import Instruction, Task
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.sensing.observation import Observation

LEARNER_S, EXPERT_S = (1.0, 6.0), (1.0, 3.0)  # length of a turn, assumed
LONG_S = 5.0  # for a task, assumed; the expert takes 2 to 4


class ControllerTakingTurns:
    """Lets two controllers act in turns, the expert first.

    Attributes:
        expert_acts: Whether the last motions are the expert's.
    """

    privileged = True

    def __init__(self, learner: Controller, expert: Controller, rng: np.random.Generator) -> None:
        self._learner, self._expert, self._rng = learner, expert, rng
        self.expert_acts, self._steps_left = False, 0
        self._begun: set[Task] = set()

    def reset(self) -> None:
        """Reset both controllers; the turn continues."""
        self._learner.reset()
        self._expert.reset()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the chunk of the controller whose turn it is."""
        if instruction.task not in self._begun:
            self._begun.add(instruction.task)
            self._since_s = observation.time_s
        takes_long = observation.time_s - self._since_s > LONG_S
        if not self.expert_acts if takes_long else self._steps_left <= 0:
            self._change()
        chunk = self._acting.act(observation, instruction)
        self._steps_left -= len(chunk)
        return chunk

    @property
    def _acting(self) -> Controller:
        return self._expert if self.expert_acts else self._learner

    def _change(self) -> None:
        self.expert_acts = not self.expert_acts
        self._acting.reset()
        turn_s = self._rng.uniform(*(EXPERT_S if self.expert_acts else LEARNER_S))
        self._steps_left = round(turn_s / CONTROL_PERIOD_S)


def expert_acts(controller: Controller) -> bool:
    """Return whether the last motions are the expert's, alone or in turns."""
    return not isinstance(controller, ControllerTakingTurns) or controller.expert_acts
