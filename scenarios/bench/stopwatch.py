"""Where the time of a function goes, measured as it runs."""

from collections.abc import Callable
from time import perf_counter
from typing import Any, Self

REST = "the rest"


class Stopwatch:
    """Times each call of one function, and the stages that are called within it.

    Every call is passed on as it is; leaving the `with` block puts the functions back. A stage's
    time is without that of the stages within it; `REST` is what no stage accounts for. Calls of a
    stage from elsewhere are not counted.

    Attributes:
        whole_s: Time of each call, s.
        stages_s: For each call the time of every stage, s.
    """

    def __init__(self, owner: Any, function: str) -> None:
        self.whole_s: list[float] = []
        self.stages_s: list[dict[str, float]] = []
        self._stages: list[str] = []
        self._within_s: list[float] = []  # spent in stages by each function under way
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
        """Counts the calls of `owner.function` to the stage `name`."""
        self._stages.append(name)
        call = getattr(owner, function)

        def timed(*args: Any, **options: Any) -> Any:
            if not self._within_s:
                return call(*args, **options)
            return self._own_time(name, call, args, options)

        self.replace(owner, function, timed)

    def replace(self, owner: Any, function: str, timed: Callable) -> None:
        """Has `owner.function` be `timed` until the watch ends."""
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
