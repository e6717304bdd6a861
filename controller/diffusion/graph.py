"""Run a policy's sampler as an ONNX Runtime graph: the same chunks, much faster than eager.

A graph has no weights, so that all policies of a configuration share it. To trace one takes a
second, so the graph of the default configuration comes with Calot. This command traces it again
after a change of networks or features: `python -m controller.diffusion.graph`.
"""

from __future__ import annotations

import io
import warnings
from pathlib import Path

import numpy as np
import onnxruntime
import torch
from numpy.typing import NDArray
from torch import Tensor

from controller.action import ACTION_SIZE
from controller.diffusion.config import WORDS_SIZE, PolicyConfig
from controller.diffusion.policy import Policy
from tissue_sim.sensing.observation import VECTOR_SIZE

OPSET = 17
SHIPPED = Path(__file__).with_name("policy.onnx")  # of `PolicyConfig()`
ELSEWHERE = "checkpoint"  # where the graph says that its weights are


class Sampler:
    """Runs the exported graph on one thread."""

    def __init__(self, policy: Policy) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        weights = {name: weight.cpu().numpy() for name, weight in policy.state_dict().items()}
        values = map(onnxruntime.OrtValue.ortvalue_from_numpy, weights.values())
        options.add_external_initializers(list(weights), list(values))
        self._session = onnxruntime.InferenceSession(
            _graph(policy), options, providers=["CPUExecutionProvider"]
        )

    def __deepcopy__(self, memo: object) -> Sampler:
        """Return the sampler itself: a copied controller may share it, as it has no state."""
        return self

    def __call__(self, inputs: dict[str, NDArray]) -> NDArray[np.float32]:
        """Return a chunk (H, 20) from `Policy.forward`'s inputs by name, without the batch axis."""
        feeds = {name: np.asarray(value)[None] for name, value in inputs.items()}
        return self._session.run(None, feeds)[0][0]  # pyright: ignore


def _graph(policy: Policy) -> bytes:
    return SHIPPED.read_bytes() if policy.config == PolicyConfig() else export(policy)


def export(policy: Policy) -> bytes:
    """Trace the sampler as ONNX, for one chunk at a time and without weights."""
    buffer, example = io.BytesIO(), example_inputs(policy.config)
    with warnings.catch_warnings():  # the newer exporter needs a package more, for the same graph
        warnings.simplefilter("ignore")
        torch.onnx.export(
            policy, tuple(example.values()), buffer,  # pyright: ignore[reportArgumentType]
            input_names=list(example),
            output_names=["chunk"], opset_version=OPSET, dynamo=False,
            do_constant_folding=False,  # it would rename weights
        )  # fmt: skip
    return _without_weights(buffer.getvalue())


def _without_weights(traced: bytes) -> bytes:
    """Let the weights of an ONNX model be given, by their names in the policy."""
    import onnx

    model = onnx.load_from_string(traced)
    for weight in model.graph.initializer:
        weight.ClearField("raw_data")
        weight.data_location = onnx.TensorProto.EXTERNAL
        weight.external_data.add(key="location", value=ELSEWHERE)
    return model.SerializeToString()


def example_inputs(config: PolicyConfig) -> dict[str, Tensor]:
    """Return inputs of `Policy.forward` by name, of the right shapes."""
    none = torch.zeros(1, dtype=torch.int64)
    return {
        "history": torch.zeros(1, len(config.history), VECTOR_SIZE),
        "jaw_rad": torch.zeros(1, 2),
        "words": torch.zeros(1, WORDS_SIZE),
        "past": torch.zeros(1, config.past, ACTION_SIZE),
        "n_past": none,
        "delay": none.clone(),
        "noise": torch.zeros(1, config.horizon, ACTION_SIZE),
    }


if __name__ == "__main__":
    SHIPPED.write_bytes(export(Policy(PolicyConfig()).eval()))
