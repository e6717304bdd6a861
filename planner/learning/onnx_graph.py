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
ELSEWHERE = "checkpoint"  # where a graph without weights says that they are


class OnnxGraph:
    """An exported network; copies of its user share it, as it has no state."""

    def __init__(self, graph: bytes, weights: Mapping[str, Tensor] | None = None) -> None:
        """Load a graph of `export`; one without weights gets them by name."""
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        if weights is not None:
            arrays = (weight.cpu().numpy() for weight in weights.values())
            values = list(map(onnxruntime.OrtValue.ortvalue_from_numpy, arrays))
            options.add_external_initializers(list(weights), values)
        self._session = onnxruntime.InferenceSession(
            graph, options, providers=["CPUExecutionProvider"]
        )

    def __deepcopy__(self, memo: object) -> OnnxGraph:
        return self

    def run(self, inputs: Mapping[str, NDArray]) -> list[NDArray[np.float32]]:
        """Return the outputs for one input by name; neither has the batch axis."""
        feeds = {name: np.asarray(value)[None] for name, value in inputs.items()}
        return [np.asarray(output)[0] for output in self._session.run(None, feeds)]


def export(
    network: nn.Module,
    example: Mapping[str, Tensor],
    outputs: Sequence[str],
    *,
    with_weights: bool = True,
) -> bytes:
    """Trace a network for inputs of the shapes of an example, by name, in their order."""
    buffer = io.BytesIO()
    with warnings.catch_warnings():  # the newer exporter needs another package
        warnings.simplefilter("ignore")
        torch.onnx.export(
            network, tuple(example.values()), buffer,  # pyright: ignore[reportArgumentType]
            input_names=list(example),
            output_names=list(outputs), opset_version=OPSET, dynamo=False,
            do_constant_folding=with_weights,  # it would rename weights
        )  # fmt: skip
    return buffer.getvalue() if with_weights else _without_weights(buffer.getvalue())


def _without_weights(traced: bytes) -> bytes:
    """Let the weights of an ONNX model be given, by their names in the network."""
    import onnx

    model = onnx.load_from_string(traced)
    for weight in model.graph.initializer:
        weight.ClearField("raw_data")
        weight.data_location = onnx.TensorProto.EXTERNAL
        weight.external_data.add(key="location", value=ELSEWHERE)
    return model.SerializeToString()
