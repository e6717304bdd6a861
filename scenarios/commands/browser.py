"""Serve the page in the browser, for commands that open one."""

from __future__ import annotations

from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from scenarios.loop.episode_config import EpisodeConfig

if TYPE_CHECKING:
    from scenarios.viewer.session_state import SessionState

LOCAL = "127.0.0.1"


def new_session(
    config: EpisodeConfig, out: Path, *, paused: bool, restarts: bool, camera: bool
) -> SessionState:
    """Create a viewer session that begins with this episode."""
    from scenarios.viewer.pace import Pace
    from scenarios.viewer.session_state import SessionState
    from scenarios.viewer.watcher import Watcher

    pace = Pace(paused=paused)
    watcher = Watcher(pace, camera=camera)
    return SessionState(config=config, out=out, pace=pace, watcher=watcher, restarts=restarts)


def page_of(
    session: SessionState, host: str, port: int | None, say_port: int | None = None
) -> AbstractContextManager[None]:
    """Serve the page while the block lasts, and print its address.

    Raises:
        BadInputError: The page cannot be served on this port.
    """
    from scenarios.viewer.serving.open_page import serve
    from scenarios.viewer.serving.page_process import PageProcess
    from scenarios.viewer.serving.port import choose_port

    if say_port is not None:
        choose_port(host, say_port, "--say-port")
    return serve(
        lambda free: PageProcess(session, host=host, port=free, say_port=say_port),
        host,
        port,
        say_port,
    )
