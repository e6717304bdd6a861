"""Several worlds in one process, stepped side by side by threads.

A tissue step runs outside Python's interpreter lock, so that threads overlap; the worlds share
nothing, so that the result does not depend on the number of threads, to the bit. The slowest
world goes first: begun last, it would have one thread at work while the others wait.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from time import perf_counter
from types import TracebackType
from typing import Self

from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.sensing.observation import Observation
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World, WorldConfig


class Worlds:
    """A number of operating fields, without pictures."""

    def __init__(
        self, number: int, *, threads: int | None = None, config: WorldConfig | None = None
    ) -> None:
        """Empty fields.

        Args:
            number: of worlds.
            threads: that step them; as many as there are cores to run on by default.
            config: of each world.
        """
        self.worlds = tuple(World(config=config) for _ in range(number))
        self._took_s = [0.0] * number  # the last step of each; how tissue is held changes slowly
        self._pool = ThreadPoolExecutor(threads or len(os.sched_getaffinity(0)))

    def reset(self, anatomies: Sequence[Anatomy]) -> list[Observation]:
        """A new patient in each world."""
        pairs = zip(self.worlds, anatomies, strict=True)
        return list(self._pool.map(lambda pair: pair[0].reset(pair[1]), pairs))

    def step(self, commands: Sequence[JointCommand]) -> list[Observation]:
        """One control period of every world.

        Raises:
            ValueError: there is not one command for each, and nothing has moved; or one is bad, and
                the other worlds have moved.
        """
        if len(commands) != len(self.worlds):
            raise ValueError(f"worlds: {len(self.worlds)} need as many commands: {len(commands)}")
        slowest_first = sorted(range(len(commands)), key=self._took_s.__getitem__, reverse=True)
        steps = {k: self._pool.submit(self._step, k, commands[k]) for k in slowest_first}
        wait(steps.values())
        return [steps[k].result() for k in range(len(commands))]

    def _step(self, k: int, command: JointCommand) -> Observation:
        start_s = perf_counter()
        seen = self.worlds[k].step(command)
        self._took_s[k] = perf_counter() - start_s
        return seen

    def close(self) -> None:
        """End the threads."""
        self._pool.shutdown()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
