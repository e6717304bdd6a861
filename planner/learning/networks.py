"""Run every network alike: within bounds of its size and input, on one thread, and loaded once.

The bounds of sizes refuse a checkpoint whose network takes a gigabyte. Inputs are normalised within
bounds. On one thread, outputs are identical to the bit for any number of processors.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Annotated, TypeVar

import torch
from msgspec import Meta
from torch import nn

T = TypeVar("T")
Width = Annotated[int, Meta(ge=1, le=1024)]
Channels = Annotated[int, Meta(ge=1, le=256)]  # of convolutions
Layers = Annotated[int, Meta(ge=0, le=12)]
Steps = Annotated[int, Meta(ge=0, le=64)]  # of time, or of a computation
SomeSteps = Annotated[int, Meta(ge=1, le=64)]
Weight = Annotated[float, Meta(ge=0.0, le=10.0)]

MIN_DEVIATION = 1e-3  # of a feature or of a chunk's entry: tiny variations are not amplified
MAX_DEVIATIONS = 6.0  # values outside the training's range are clipped here


def convolution(inputs: int, outputs: int, stride: int = 1) -> nn.Sequential:
    """Return a convolution of 3 by 3 cells, with batch normalisation and a rectifier."""
    conv = nn.Conv2d(inputs, outputs, 3, stride, 1, bias=False)
    return nn.Sequential(conv, nn.BatchNorm2d(outputs), nn.ReLU(inplace=True))


@contextmanager
def one_thread() -> Iterator[None]:
    """Run PyTorch on one thread: on several, the last bits of a sum depend on their number."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def kept(load: Callable[[Path], T]) -> Callable[[Path], T]:
    """Return a loader that loads a file once, until it changes or another file is requested.

    All callers share the loaded object, so the object must have no state.
    """

    @lru_cache(maxsize=1)
    def loaded(path: Path, written_ns: int) -> T:
        del written_ns  # a file that is written anew is another file
        return load(path)

    return lambda path: loaded(path, path.stat().st_mtime_ns if path.exists() else 0)
