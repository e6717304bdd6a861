"""Run a network as a graph for ONNX Runtime on one thread: the same outputs, faster than eager."""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping, Sequence

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

OPSET = 17


class OnnxGraph:
    """An exported network; copies of its user share it, as it has no state."""

    def __init__(
        self, network: nn.Module, example: Mapping[str, Tensor], outputs: Sequence[str]
    ) -> None:
        """Export a network for inputs of the shapes of an example, by name, in their order."""
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        buffer = io.BytesIO()
        with warnings.catch_warnings():  # the newer exporter needs another package
            warnings.simplefilter("ignore")
            torch.onnx.export(
                network, tuple(example.values()), buffer,  # pyright: ignore[reportArgumentType]
                input_names=list(example),
                output_names=list(outputs), opset_version=OPSET, dynamo=False,
            )  # fmt: skip
        self._session = onnxruntime.InferenceSession(
            buffer.getvalue(), options, providers=["CPUExecutionProvider"]
        )

    def __deepcopy__(self, memo: object) -> OnnxGraph:
        return self

    def run(self, inputs: Mapping[str, NDArray]) -> list[NDArray[np.float32]]:
        """Return the outputs for one input by name; neither has the batch axis."""
        feeds = {name: np.asarray(value)[None] for name, value in inputs.items()}
        return [np.asarray(output)[0] for output in self._session.run(None, feeds)]
