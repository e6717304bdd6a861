"""The nearest capsules of each chain to each link: a bound for all at once, FCL for the nearest."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from controller.safety.gap import MM, Core, Gap, gap
from controller.safety.link_cores import LinkCores
from controller.safety.surroundings import CapsuleChain


class ChainSearch:
    """The capsules of all chains as they are in one step; FCL sees those that may be nearest."""

    def __init__(self, chains: Mapping[str, CapsuleChain]) -> None:
        start, end, self.radius_m = (
            np.concatenate([getattr(chain, field) for chain in chains.values()])
            for field in ("start_m", "end_m", "radius_m")
        )
        self._first = np.cumsum([0, *(len(chain.radius_m) for chain in chains.values())])
        self._chain = np.repeat(np.arange(len(chains)), np.diff(self._first))
        self._centre_m = 0.5 * (start + end)
        self._half_m = 0.5 * np.sqrt(((end - start) ** 2).sum(axis=1))
        self._ends_mm = MM * np.stack([start, end], axis=1)
        self._cores: dict[int, Core] = {}

    def near(
        self, links: LinkCores, cores: list[Core], within_m: float
    ) -> Iterator[tuple[int, int, int, Gap]]:
        """Link (0 to 7), chain, capsule (counted through all chains) and the gap of their cores.

        No capsule that is left out is nearer than one of the same chain that is given.
        """
        radii_mm = MM * (links.radius_m[:, None] + self.radius_m)
        nearest_mm: dict[tuple[int, int], float] = {}
        for link, capsule, bound_mm in self._candidates(links, within_m):
            pair = link, int(self._chain[capsule])
            if bound_mm < nearest_mm.get(pair, np.inf):
                found = gap(cores[link], self._core(capsule))
                distance_mm = found.distance_mm - radii_mm[link, capsule]
                nearest_mm[pair] = min(distance_mm, nearest_mm.get(pair, np.inf))
                yield *pair, capsule, found

    def _candidates(self, links: LinkCores, within_m: float) -> Iterator[tuple[int, int, float]]:
        """Link, capsule and a lower bound of their distance (mm), the least bound first.

        A capsule is nearer than its middle, by half its length at most.
        """
        middle = links.to_points_m(self._centre_m) - self.radius_m
        least = np.minimum.reduceat(middle, self._first[:-1], axis=1)
        bound = middle - self._half_m
        link, capsule = np.nonzero(bound < np.minimum(least, within_m)[:, self._chain])
        bound_mm = MM * bound[link, capsule]
        order = np.argsort(bound_mm, kind="stable")
        columns = (column[order].tolist() for column in (link, capsule, bound_mm))
        return zip(*columns, strict=True)

    def _core(self, capsule: int) -> Core:
        if capsule not in self._cores:
            self._cores[capsule] = Core(self._ends_mm[capsule])
        return self._cores[capsule]
