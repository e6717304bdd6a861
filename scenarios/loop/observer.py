"""Who watches an episode: recorder, video, progress, viewer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

from scenarios.loop.results import EpisodeResult

if TYPE_CHECKING:  # both are heavy to import
    from scenarios.loop.step import Step
    from tissue_sim.world import World


class Observer(Protocol):
    """Sees an episode and changes nothing in it.

    One with a true attribute `needs_images` gets a world that has cameras.
    """

    def on_reset(self, world: World) -> None:
        """The world is ready and nothing has moved yet."""
        ...

    def on_step(self, step: Step) -> None:
        """One control step is done."""
        ...

    def on_end(self, result: EpisodeResult) -> None:
        """The episode ended by itself; not called when it broke off."""
        ...
