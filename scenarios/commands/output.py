"""The console that reports are printed on."""

import os

from scenarios.files.outside_text import Terminal

WIDE = 200  # columns


def output() -> Terminal:
    """Return standard output; if it is a file or a pipe, tables are 200 columns wide."""
    console = Terminal()
    if console.is_terminal or "COLUMNS" in os.environ:
        return console
    return Terminal(width=WIDE)
