"""A controller that ignores observations: its motion depends on the number of calls."""

import numpy as np

from controller.action import ToolAction, hold


class ControllerWaves:
    """Moves both tools back and forth."""

    privileged = True

    def __init__(self, setup, world):
        self._jaw_rad = world.target[:, 6]
        self._asked = 0

    def reset(self):
        pass

    def act(self, observation, instruction):
        self._asked += 1
        still = hold(self._jaw_rad)
        swing = 0.0005 * np.sin(0.3 * self._asked)
        return (
            ToolAction(
                move_endoscope_m=np.full((2, 3), swing),
                turn_tool=still.turn_tool,
                jaw_rad=still.jaw_rad,
            ),
        )
