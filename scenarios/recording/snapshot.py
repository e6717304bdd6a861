"""A moment of a running episode, from which the episode can continue repeatedly and identically."""

from __future__ import annotations

from copy import deepcopy

from scenarios.episode import Episode
from scenarios.loop.person.inbox import Inbox


class Snapshot:
    """The state on which the next steps depend: world, planner, controller, driver, filter, chance.

    Take a snapshot between the steps of `Episode.steps`, while the controller has the arms.
    """

    def __init__(self, episode: Episode) -> None:
        self._state = episode.world.state()
        self._rate = None if (f := episode.guarded_driver.filter) is None else f.rate
        self._episode = _copied(episode)

    def again(self) -> Episode:
        """Return an episode that continues from here, with its own inbox.

        All returned episodes, and the original, share the world and the filter: only the latest can
        continue.
        """
        episode = _copied(self._episode)
        episode.world.restore(self._state)
        if (safety := episode.guarded_driver.filter) is not None and self._rate is not None:
            safety.rate = self._rate
        episode.inbox = Inbox()
        return episode


def _copied(episode: Episode) -> Episode:
    shared = (episode.world, episode.guarded_driver.filter, episode.inbox)
    return deepcopy(episode, {id(part): part for part in shared})
