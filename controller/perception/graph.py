"""Run the networks as graphs for ONNX Runtime: the same outputs, faster than eager."""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from controller.perception.checkpoint import PerceptionModel
from controller.perception.network import Network
from planner.learning.onnx_graph import OnnxGraph, export
from tissue_sim.frames import Array


class Shown(NamedTuple):
    """The output of a network for one picture: `network.Seen` without the batch axis."""

    pixels: Array
    log_sigma: Array
    inside: Array
    visible: Array
    log_radius: Array
    dense: Array
    offset: Array
    flags: Array


class ViewReader:
    """Runs the networks of all views on one thread."""

    def __init__(self, model: PerceptionModel) -> None:
        sizes = zip(model.config.views, model.config.sizes, strict=True)
        self._graphs = {
            name: OnnxGraph(
                export(
                    _Told(cast(Network, model.networks[name])).eval(),
                    {"pictures": torch.zeros(1, 3, height, width)},
                    Shown._fields,
                )
            )
            for name, (width, height) in sizes
        }

    def __call__(self, view: str, rgb: NDArray[np.uint8]) -> Shown:
        """Return the network's output for a view's picture (height, width, 3)."""
        picture = np.ascontiguousarray(rgb.transpose(2, 0, 1), np.float32) / np.float32(255.0)
        return Shown(
            *(part.astype(float) for part in self._graphs[view].run({"pictures": picture}))
        )


class _Told(nn.Module):
    """A network with a tuple as output, which the exporter requires."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, pictures: Tensor) -> tuple[Tensor, ...]:
        seen = self.network(pictures)
        return tuple(getattr(seen, name) for name in Shown._fields)
