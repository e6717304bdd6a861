"""Copies what the page needs out of the running loop, when the page asks, and never more often."""

from __future__ import annotations

from threading import Event, Lock
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scenarios.loop.results import EpisodeResult
from scenarios.viewer.event_log import EventLog, Story
from scenarios.viewer.frame import Frame, Patient, frame_of, patient_of
from scenarios.viewer.pace import Pace
from tissue_sim.periods import CONTROL_PERIOD_S

if TYPE_CHECKING:
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class Watcher:
    """Observes an episode; the loop waits for the pace, and never for a page.

    Attributes:
        needs_images: the world is to have cameras.
        patient: who lies there; None before the first.
        frame: the newest; None before the first.
        picture: (height, width, 3) what the endoscope saw last, where the world has cameras.
    """

    def __init__(self, pace: Pace, *, camera: bool = False) -> None:
        self.needs_images = camera
        self.patient: Patient | None = None
        self.frame: Frame | None = None
        self.picture: NDArray[np.uint8] | None = None
        self._pace = pace
        self._asked, self._picture_asked = Event(), Event()
        self._lock = Lock()
        self._chronicle = EventLog()
        self._world: World | None = None
        self._step: Step | None = None

    def ask(self, *, picture: bool = False) -> None:
        """Have the loop leave a new frame, and a picture, soon."""
        self._asked.set()
        if picture and self.needs_images:
            self._picture_asked.set()
        self._pace.wake()

    def story(self) -> Story:
        """What has happened so far."""
        with self._lock:
            return self._chronicle.read()

    def on_reset(self, world: World) -> None:
        """Another patient; waits until a person starts."""
        self._world, self._step = world, None
        with self._lock:
            self._chronicle = EventLog()
        self.patient = patient_of(world)
        self._copy()
        self._pace.wait(0.0, self._serve)

    def on_step(self, step: Step) -> None:
        """Notes the step, copies the world if asked to, and waits for the next one's time."""
        self._step = step
        with self._lock:
            self._chronicle.note(step)
        self._pace.wait(CONTROL_PERIOD_S, self._serve)

    def on_end(self, result: EpisodeResult) -> None:
        """Notes what it came to, an error included."""
        with self._lock:
            self._chronicle.end(result)
        self._copy()

    def rest(self) -> None:
        """Goes on serving the page until another episode is wanted, which it raises."""
        self._pace.rest(self._serve)

    def _serve(self) -> None:
        if self._asked.is_set():
            self._asked.clear()
            self._copy()
        if self._picture_asked.is_set():
            self._picture_asked.clear()
            self.picture = None if self._world is None else self._world.endoscope_rgb()

    def _copy(self) -> None:
        if self._world is None or self.patient is None:  # an episode that could not even begin
            return
        ahead = () if self._step is None else self._step.ahead
        self.frame = frame_of(self._world, self.patient, ahead, self.frame)
