"""Copy the page's data out of the running loop, only on the page's request."""

from __future__ import annotations

from threading import Event
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scenarios.loop.results import EpisodeResult
from scenarios.recording.event_log import EpisodeStatus, EventLog
from scenarios.viewer.frame import Frame, Patient, frame_of, patient_of
from scenarios.viewer.pace import Pace
from tissue_sim.constants import CONTROL_PERIOD_S

if TYPE_CHECKING:
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class Watcher:
    """Observes an episode. The loop waits for the pace, never for a page.

    Attributes:
        needs_images: Whether the world must have cameras.
        patient: The current patient; None before the first.
        frame: The newest frame; None before the first.
        picture: (height, width, 3) newest endoscope picture, where the world has cameras.
    """

    def __init__(self, pace: Pace, *, camera: bool = False) -> None:
        self.needs_images = camera
        self.patient: Patient | None = None
        self.frame: Frame | None = None
        self.picture: NDArray[np.uint8] | None = None
        self._pace = pace
        self._asked, self._picture_asked = Event(), Event()
        self._log = EventLog()
        self._world: World | None = None
        self._step: Step | None = None

    def ask(self, *, picture: bool = False) -> None:
        """Ask the loop for a new frame, and for a picture if `picture`."""
        self._asked.set()
        if picture and self.needs_images:
            self._picture_asked.set()
        self._pace.wake()

    def status(self) -> EpisodeStatus:
        """Return the episode's log and progress so far."""
        return self._log.status

    def on_reset(self, world: World) -> None:
        """Show another patient, and wait until a person starts the episode."""
        self._world, self._step = world, None
        self._log = EventLog()
        self.patient = patient_of(world)
        self._copy()
        self._pace.wait(0.0, self._serve)

    def on_step(self, step: Step) -> None:
        """Log the step, copy the world if requested, and wait until the next step is due."""
        self._step = step
        self._log.note(step)
        self._pace.wait(CONTROL_PERIOD_S, self._serve)

    def on_end(self, result: EpisodeResult) -> None:
        """Log the result, or the error."""
        self._log.end(result)
        self._copy()

    def rest(self) -> None:
        """Serve the page until a person starts another episode, which raises `Restart`."""
        self._pace.rest(self._serve)

    def _serve(self) -> None:
        if self._asked.is_set():
            self._asked.clear()
            self._copy()
        if self._picture_asked.is_set():
            self._picture_asked.clear()
            self.picture = None if self._world is None else self._world.endoscope_rgb()

    def _copy(self) -> None:
        if self._world is None or self.patient is None:  # the episode could not begin
            return
        ahead, observation = (
            ((), None) if self._step is None else (self._step.ahead, self._step.observation)
        )
        self.frame = frame_of(self._world, self.patient, ahead, self.frame, observation)
