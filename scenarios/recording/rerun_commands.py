"""Run a recorded episode's commands through the world again, to recover the tissue.

A recording holds what was commanded and what the arms did, not the tissue. The world is
deterministic, so the same commands on the same patient, disturbed in the same way, move the same
tissue. Arms that are the same, bit for bit, show this.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from planner.criteria import structure_of
from planner.instruction import TASKS
from scenarios.files.strict_json import plain
from scenarios.loop.episode_config import EpisodeConfig
from scenarios.perturbation.effects import Effects
from scenarios.perturbation.manual import MANUAL
from scenarios.recording.recorder import RIGHT_TOOLS, Recording
from scenarios.run_episode import anatomy_of
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World


class CommandRerun:
    """One recording and the world that it runs through.

    Attributes:
        world: the patient on the table, before the first step.
        n_steps: number of steps.
    """

    def __init__(self, recording: Recording) -> None:
        """Put the patient on the table.

        Raises:
            ValueError: the recording is of another version, which has other options or patients.
        """
        self._recording, self._config = recording, config_of(recording)
        self.n_steps = len(recording.arrays["time_s"])
        self.world = World()
        self._effects = Effects(self._config.perturbations, self._config.seed)
        self.world.reset(self._effects.on_anatomy(anatomy_of(self._config)))
        if recording.anatomy is not None and plain(self.world.anatomy) != recording.anatomy:
            raise ValueError(
                f"seed {self._config.seed} is another patient now than in the recording,"
                f" which was made with {recording.versions}"
            )

    def steps(self) -> Iterator[bool]:
        """Run the steps; after each, yield whether the arms match the recording, to the bit."""
        for k in range(self.n_steps):
            yield np.array_equal(self._step(k), self._recording.arrays["joints"][k])

    def _step(self, k: int) -> np.ndarray:
        """Return (2, 7) joints after step `k`."""
        arrays, world = self._recording.arrays, self.world
        task = TASKS[self._recording.instructions[arrays["instruction"][k]]["task"] - 1]
        if self._nurse_came(k):
            world.equip(RIGHT_TOOLS[arrays["right_tool"][k]])
        for name, magnitude in self._manual(k):
            self._effects.add(replace(MANUAL[name], magnitude=magnitude))
        self._effects.before_step(world, task)
        command = JointCommand(joints=arrays["commands"][k])
        return world.step(command, intended=structure_of(task, world)).joints

    def _nurse_came(self, k: int) -> bool:
        """Return whether a tool was exchanged or a clip loaded before this step."""
        tool, loaded = self._recording.arrays["right_tool"], self._recording.arrays["clip_loaded"]
        tool_before, loaded_before = (tool[k - 1], loaded[k - 1]) if k else (0, 1)
        return bool(tool[k] != tool_before or loaded[k] > loaded_before)

    def _manual(self, k: int) -> list[tuple[str, float]]:
        """Return the perturbations, with magnitudes, that a person caused at this step."""
        return [
            (p["name"], p["magnitude"])
            for p in self._recording.perturbations
            if p["step"] == k and p["name"] in MANUAL
        ]


def config_of(recording: Recording) -> EpisodeConfig:
    """Return the configuration of a recording.

    Raises:
        ValueError: this version does not know it.
    """
    try:
        made = EpisodeConfig(**recording.config)
    except TypeError as error:
        raise ValueError(f"its configuration is of another version: {error}") from None
    return replace(made, cameras=tuple(made.cameras))  # a list in JSON
