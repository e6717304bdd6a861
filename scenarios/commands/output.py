"""The console that reports are printed on."""

import os

from rich.console import Console

from scenarios.files.closed_pipe import PatientConsole

WIDE = 200  # columns


def output() -> Console:
    """Return standard output; if it is a file or a pipe, tables are 200 columns wide."""
    console = PatientConsole()
    if console.is_terminal or "COLUMNS" in os.environ:
        return console
    return PatientConsole(width=WIDE)
