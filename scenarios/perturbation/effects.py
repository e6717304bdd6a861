"""All perturbations of an episode as one."""

from __future__ import annotations

from collections.abc import Sequence
from pkgutil import resolve_name
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from controller.action import ToolAction
from planner.procedure.task import Task
from scenarios.perturbation.effect import Applied, Effect
from scenarios.perturbation.perturbation import Perturbation
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.sensing.sensor_model import SensorModel

if TYPE_CHECKING:
    from tissue_sim.world import World


class Effects:
    """Applies perturbations in their order, except those of magnitude 0."""

    def __init__(self, perturbations: Sequence[Perturbation] = (), seed: int = 0) -> None:
        self._seed, self._seen = seed, 0
        self._effects: list[Effect] = [
            _effect(p, seed, k) for k, p in enumerate(perturbations) if p.magnitude
        ]

    def add(self, perturbation: Perturbation) -> None:
        """Add a perturbation during the episode."""
        self._effects.append(_effect(perturbation, self._seed, len(self._effects)))

    def on_anatomy(self, anatomy: Anatomy) -> Anatomy:
        """Return the patient to operate on."""
        for effect in self._effects:
            anatomy = effect.on_anatomy(anatomy)
        return anatomy

    def on_senses(self, model: SensorModel) -> SensorModel:
        """Return the errors of the sense `tracked`."""
        for effect in self._effects:
            model = effect.on_senses(model)
        return model

    def on_picture(self, camera: str, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Return the picture (height, width, 3) that a camera delivers to perception."""
        for effect in self._effects:
            rgb = effect.on_picture(camera, rgb)
        return rgb

    def lead(self, world: World, task: Task) -> ToolAction | None:
        """Return the next motion while an arm is led astray; None while the controller acts."""
        led = (effect.lead(world, task) for effect in self._effects)
        return next((action for action in led if action is not None), None)

    def on_action(self, action: ToolAction, world: World, task: Task) -> ToolAction:
        """Return the action that reaches the driver."""
        for effect in self._effects:
            action = effect.on_action(action, world, task)
        return action

    def before_step(self, world: World, task: Task) -> None:
        """Change the world before its next control step."""
        for effect in self._effects:
            effect.before_step(world, task)
        offsets = [o for e in self._effects if (o := e.offset_m(world)) is not None]
        if offsets:
            world.shift_body(np.sum(offsets, axis=0))

    def news(self) -> tuple[Applied, ...]:
        """Return the onsets since the last call."""
        applied = sorted((a for e in self._effects for a in e.applied), key=lambda a: a.time_s)
        seen, self._seen = self._seen, len(applied)
        return tuple(applied[seen:])


def _effect(perturbation: Perturbation, seed: int, k: int) -> Effect:
    rng = np.random.default_rng([0xD157, seed, k])
    return resolve_name(perturbation.effect)(perturbation, rng)
