"""What people did in an episode, as training data: its frames so far, labelled by what was said."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING

import numpy as np

from controller.action import CONTROL_STEP_S
from controller.dataset.episode import Episode, Header
from controller.dataset.part import part_bytes
from controller.dataset.tables import strings
from scenarios.demonstration.mix import INTERVENTION
from scenarios.demonstration.witness import Witness
from scenarios.episode_config import EpisodeConfig
from scenarios.results import EpisodeResult
from scenarios.strict_json import plain
from scenarios.versions import versions

if TYPE_CHECKING:
    from scenarios.episode import Step
    from tissue_sim.world import World

SEEN_S = 1.0  # what a person corrects went wrong this long before; assumed
EXPERT = "expert"


class Interventions:
    """Observes an episode; what it has seen so far can be had from any thread.

    A person's correction labels its own frames and those of the second before. Only the expert and
    a person's hand are to be imitated.

    Attributes:
        corrected: frames in which a person corrected or led an arm.
    """

    def __init__(self, config: EpisodeConfig) -> None:
        self._config, self._lock = config, Lock()
        self._said: list[str] = []
        self._imitated: list[bool] = []
        self.corrected = 0

    def on_reset(self, world: World) -> None:
        """The first frame's observation."""
        self._world, self._witness = world, Witness(INTERVENTION)
        self._witness.on_reset(world)

    def on_step(self, step: Step) -> None:
        """One frame, if policies had the arms."""
        with self._lock:
            self._witness.on_step(step)
            if step.exchange or step.instruction.hold:
                return
            human = step.instruction.source == "human"
            correction, by_hand = step.instruction.correction, step.hand is not None
            self._said.append(correction.text if human and correction else "")
            by_expert = self._config.controller == EXPERT and not step.disturbed
            self._imitated.append(by_hand or by_expert)
            self.corrected += by_hand or human

    def on_end(self, result: EpisodeResult) -> None:
        """Adds nothing."""

    def part(self) -> bytes:
        """The content of a file for `controller.dataset.part.read_part`.

        Raises:
            ValueError: there is no frame yet.
        """
        with self._lock:
            if not self._said:
                raise ValueError("there is no frame yet")
            columns = self._witness.columns(self._config.seed, INTERVENTION)
            wanted = labelled(self._said)
            columns["expert"] = np.array(self._imitated)
        columns["correction"] = strings(wanted)
        columns["flag"] = np.array([bool(text) for text in wanted])
        header = Header(
            seed=self._config.seed,
            kind=INTERVENTION,
            scenario=self._config.scenario,
            success=False,  # nobody knows yet
            failures=[],
            anatomy=plain(self._world.anatomy),
            versions=versions(),
        )
        return part_bytes(Episode(header=header, columns=columns))


def labelled(said: list[str]) -> list[str]:
    """Each frame's correction, spread to the frames before it in which it was already wanted."""
    wanted, before = list(said), round(SEEN_S / CONTROL_STEP_S)
    for k in range(len(said)):
        if said[k] and (k == 0 or said[k - 1] != said[k]):
            for earlier in range(max(0, k - before), k):
                wanted[earlier] = said[earlier] or said[k]
    return wanted
