"""Who watches an episode: recorder, video, progress, viewer."""

from typing import Any, Protocol

from scenarios.results import EpisodeResult


class Observer(Protocol):
    """Sees an episode and changes nothing in it."""

    def on_reset(self, world: Any) -> None:
        """The world is ready and nothing has moved yet."""
        ...

    def on_step(self, step: Any) -> None:
        """One control step is done."""
        ...

    def on_end(self, result: EpisodeResult) -> None:
        """The episode ended by itself; not called when it broke off."""
        ...
