"""Edit recordings as somebody would who knows the format: with a hash that fits, or without."""

import json
from pathlib import Path

import numpy as np

from scenarios.recording.recorder import HASH, HEADER, recording_bytes


def parts_of(path: Path):
    """Return header and arrays of a recording."""
    with np.load(path) as file:
        arrays = {name: file[name].copy() for name in file if name not in (HEADER, HASH)}
        return json.loads(str(file[HEADER])), arrays


def tampered(source: Path, target: Path, edit) -> Path:
    """Write a copy whose header and arrays `edit` has changed in place, and whose hash fits."""
    header, arrays = parts_of(source)
    edit(header, arrays)
    target.parent.mkdir(exist_ok=True)
    target.write_bytes(recording_bytes(header, arrays))
    return target
