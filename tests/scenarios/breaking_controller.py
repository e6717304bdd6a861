"""A controller that raises an exception during an episode."""

from controller.holding import ControllerIdle

BREAKS = f"{__name__}:ControllerBreaks"  # its name on the command line
BREAKS_AT_S = 0.2


class ControllerBreaks(ControllerIdle):
    """Raises an exception after a while in episodes of even seeds; holds still in the others."""

    def __init__(self, setup):
        super().__init__(setup)
        self._even = setup.seed % 2 == 0

    def act(self, observation, instruction):
        if self._even and observation.time_s > BREAKS_AT_S:
            raise RuntimeError("a string snapped")
        return super().act(observation, instruction)
