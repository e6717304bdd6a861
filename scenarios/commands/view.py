"""`calot view`: watch the procedure in the browser, and correct it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import arg

from scenarios.commands.browser import LOCAL, new_session, page_of
from scenarios.commands.episode_options import EpisodeOptions
from scenarios.commands.folder_options import claimed, require_writable_folder
from scenarios.commands.policy_options import require_renderer, say_who_acts
from scenarios.commands.typed_options import at_least


@dataclass(frozen=True, kw_only=True)
class View(EpisodeOptions):
    """Watch episodes in the browser, correct them by button or sentence; until Ctrl-C.

    Exit code: 0 ended between two episodes, 130 in one, which is kept; 2 bad input.
    """

    out: Path = Path("runs/view")
    """Folder for the recorded episodes, which replace no older ones, and for interventions that are
    kept as training data."""
    host: Annotated[str, arg(metavar="ADDRESS")] = LOCAL
    """Address to listen on; beyond this machine a token in the printed address is asked for."""
    port: Annotated[int | None, at_least(1)] = None
    """Port to listen on; the default is the first free one from 8080 on."""
    say_port: Annotated[int | None, at_least(1)] = None
    """Port of a page with a microphone, and of `POST /say` for other programs; none by default."""
    camera: bool = False
    """Whether the endoscope's picture is shown, too; needs a renderer, and slows the loop down."""
    start: bool = False
    """Whether to start at once, and not when somebody presses Start."""

    def execute(self) -> int:
        """Serve the page until a signal; return 0 if the signal comes between two episodes."""
        self.require_episode()
        require_writable_folder(self.out, "--out")
        if self.camera:
            require_renderer("--camera")
        from scenarios.viewer.session import watch_episodes

        session = new_session(
            self.first_config(), self.out, paused=not self.start, restarts=True, camera=self.camera
        )
        with (
            claimed(self.out, "--out"),
            page_of(session, self.host, self.port, self.say_port),
        ):
            say_who_acts(self.planner, self.controller, self.sense_in_force)
            watch_episodes(session)
        return 0
