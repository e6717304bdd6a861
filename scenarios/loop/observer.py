"""The interface of observers of an episode: recorder, video, progress, viewer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from scenarios.loop.results import EpisodeResult

if TYPE_CHECKING:  # both are heavy to import
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class Observer(Protocol):
    """Observes an episode and changes nothing in it.

    An observer whose attribute `needs_images` is true gets a world with cameras.
    """

    def on_reset(self, world: World) -> None:
        """Observe the world before anything moves."""
        ...

    def on_step(self, step: Step) -> None:
        """Observe one finished control step."""
        ...

    def on_end(self, result: EpisodeResult) -> None:
        """Observe the result; not called if the episode broke off."""
        ...
