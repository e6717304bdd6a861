"""Run the networks as graphs for ONNX Runtime: the same outputs, faster than eager."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from controller.perception.checkpoint import PerceptionModel
from controller.perception.network import Network
from tissue_sim.frames import Array

OPSET = 17
TOLD = ("pixels", "log_sigma", "inside", "visible", "log_radius", "dense", "offset", "flags")


@dataclass(frozen=True, kw_only=True)
class Shown:
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
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._sessions = {
            name: onnxruntime.InferenceSession(
                export(model.networks[name], size),  # pyright: ignore[reportArgumentType]
                options,
                providers=["CPUExecutionProvider"],
            )
            for name, size in zip(model.config.views, model.config.sizes, strict=True)
        }

    def __deepcopy__(self, memo: object) -> ViewReader:
        """Return the reader itself: copies of a perception may share it, as it has no state."""
        return self

    def __call__(self, view: str, rgb: NDArray[np.uint8]) -> Shown:
        """Return the network's output for a view's picture (height, width, 3)."""
        feed = np.ascontiguousarray(rgb.transpose(2, 0, 1)[None], np.float32) / np.float32(255.0)
        outputs = map(np.asarray, self._sessions[view].run(None, {"pictures": feed}))
        parts = zip(TOLD, outputs, strict=True)
        return Shown(**{name: part[0].astype(float) for name, part in parts})


class _Told(nn.Module):
    """A network with a tuple as output, which the exporter requires."""

    def __init__(self, network: Network) -> None:
        super().__init__()
        self.network = network

    def forward(self, pictures: Tensor) -> tuple[Tensor, ...]:
        seen = self.network(pictures)
        return tuple(getattr(seen, name) for name in TOLD)


def export(network: Network, size: tuple[int, int]) -> bytes:
    """Return a network as ONNX, for one picture of this width and height at a time."""
    width, height = size
    buffer, example = io.BytesIO(), torch.zeros(1, 3, height, width)
    with warnings.catch_warnings():  # the newer exporter needs a package more, for the same graph
        warnings.simplefilter("ignore")
        torch.onnx.export(
            _Told(network).eval(), (example,), buffer,  # pyright: ignore[reportArgumentType]
            input_names=["pictures"], output_names=list(TOLD), opset_version=OPSET, dynamo=False,
        )  # fmt: skip
    return buffer.getvalue()
