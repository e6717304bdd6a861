"""Where reports are printed."""

import os

from rich.console import Console

WIDE = 200  # columns


def output() -> Console:
    """Standard output; tables are not squeezed where it is a file or a pipe, which has no width."""
    console = Console()
    if console.is_terminal or "COLUMNS" in os.environ:
        return console
    return Console(width=WIDE)
