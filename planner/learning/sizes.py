"""Define bounds of a network's sizes, so that a checkpoint that takes a gigabyte is refused."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta

Width = Annotated[int, Meta(ge=1, le=1024)]
Channels = Annotated[int, Meta(ge=1, le=256)]  # of convolutions
Layers = Annotated[int, Meta(ge=0, le=12)]
Steps = Annotated[int, Meta(ge=0, le=64)]  # of time, or of a computation
SomeSteps = Annotated[int, Meta(ge=1, le=64)]
