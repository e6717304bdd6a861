"""Set how often a process that runs episodes searches for garbage."""

import gc

OBJECTS = 100_000  # Python's own 700 costs half a second while libraries are imported


def search_garbage_rarely() -> None:
    """Let Python search for garbage only after `OBJECTS` new objects, in this whole process.

    A program that calls `run_episode` itself decides this for itself.
    """
    gc.set_threshold(OBJECTS)
