"""Step several worlds in one process at the same time, with threads.

A tissue step runs outside Python's interpreter lock, so threads overlap. The worlds share nothing,
so the number of threads does not change any bit of the result. The slowest world starts first;
otherwise the other threads would wait for it at the end.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from time import perf_counter
from typing import Self

from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World, WorldConfig


class Worlds:
    """Several worlds, without pictures."""

    def __init__(
        self, number: int, *, threads: int | None = None, config: WorldConfig | None = None
    ) -> None:
        """Make worlds without patients.

        Args:
            number: Number of worlds.
            threads: Number of threads; by default, the cores that this process may use.
            config: Configuration of each world.
        """
        self.worlds = tuple(World(config=config) for _ in range(number))
        self._took_s = [0.0] * number  # duration of each world's last step, which changes slowly
        self._pool = ThreadPoolExecutor(threads or len(os.sched_getaffinity(0)))

    def reset(self, anatomies: Sequence[Anatomy]) -> list[Observation]:
        """Load a new patient in each world.

        Raises:
            ValueError: the number of patients is wrong, and no world has changed; or one value is
                no patient, and the other worlds have loaded theirs.
            ArithmeticError: a patient's tissue does not stay finite; the other worlds have loaded
                their patients.
        """
        if len(anatomies) != len(self.worlds):
            raise ValueError(f"worlds: {len(self.worlds)} need as many patients: {len(anatomies)}")
        pairs = zip(self.worlds, anatomies, strict=True)
        return list(self._pool.map(lambda pair: pair[0].reset(pair[1]), pairs))

    def step(self, commands: Sequence[JointCommand]) -> list[Observation]:
        """Advance every world by one control period.

        Raises:
            ValueError: the number of commands is wrong, and nothing has moved; or one command is
                invalid, and the other worlds have moved.
        """
        if len(commands) != len(self.worlds):
            raise ValueError(f"worlds: {len(self.worlds)} need as many commands: {len(commands)}")
        slowest_first = sorted(range(len(commands)), key=self._took_s.__getitem__, reverse=True)
        steps = {k: self._pool.submit(self._step, k, commands[k]) for k in slowest_first}
        wait(steps.values())
        return [steps[k].result() for k in range(len(commands))]

    def _step(self, k: int, command: JointCommand) -> Observation:
        start_s = perf_counter()
        observation = self.worlds[k].step(command)
        self._took_s[k] = perf_counter() - start_s
        return observation

    def close(self) -> None:
        """Stop the threads."""
        self._pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()
