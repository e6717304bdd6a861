"""Measure the time of a function and of its stages."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any, Self

REST = "the rest"


class Stopwatch:
    """Times each call of one function, and of the stages that the function calls.

    Calls are passed on unchanged; leaving the `with` block restores the functions. A stage's time
    excludes that of the stages inside it; `REST` is the time in no stage. Calls of a stage from
    outside the function are not counted.

    Attributes:
        whole_s: Time of each call, s.
        stages_s: For each call the time of every stage, s.
    """

    def __init__(self, owner: Any, function: str) -> None:
        self.whole_s: list[float] = []
        self.stages_s: list[dict[str, float]] = []
        self._stages: list[str] = []
        self._within_s: list[float] = []  # time in stages, of each running function
        self._watched: list[tuple[Any, str, Callable]] = []
        whole = getattr(owner, function)

        def timed(*args: Any, **options: Any) -> Any:
            self.stages_s.append(dict.fromkeys(self._stages, 0.0))
            start_s = perf_counter()
            result = self._own_time(REST, whole, args, options)
            self.whole_s.append(perf_counter() - start_s)
            return result

        self.replace(owner, function, timed)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        for owner, function, original in reversed(self._watched):
            setattr(owner, function, original)

    def stage(self, owner: Any, function: str, name: str) -> None:
        """Count the calls of `owner.function` as the stage `name`."""
        self._stages.append(name)
        call = getattr(owner, function)

        def timed(*args: Any, **options: Any) -> Any:
            if not self._within_s:
                return call(*args, **options)
            return self._own_time(name, call, args, options)

        self.replace(owner, function, timed)

    def replace(self, owner: Any, function: str, timed: Callable) -> None:
        """Replace `owner.function` by `timed` until the `with` block ends."""
        self._watched.append((owner, function, getattr(owner, function)))
        setattr(owner, function, timed)

    def _own_time(self, stage: str, call: Callable, args: tuple, options: dict[str, Any]) -> Any:
        self._within_s.append(0.0)
        start_s = perf_counter()
        try:
            return call(*args, **options)
        finally:
            spent_s = perf_counter() - start_s
            own_s = spent_s - self._within_s.pop()
            self.stages_s[-1][stage] = self.stages_s[-1].get(stage, 0.0) + own_s
            if self._within_s:
                self._within_s[-1] += spent_s
