"""Run a policy's sampler as an ONNX Runtime graph: the same chunks, much faster than eager."""

from __future__ import annotations

import io
import warnings

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


class Sampler:
    """Runs the exported graph on one thread."""

    def __init__(self, policy: Policy) -> None:
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._session = onnxruntime.InferenceSession(
            export(policy), options, providers=["CPUExecutionProvider"]
        )

    def __deepcopy__(self, memo: object) -> Sampler:
        """Return the sampler itself: a copied controller may share it, as it has no state."""
        return self

    def __call__(self, inputs: dict[str, NDArray]) -> NDArray[np.float32]:
        """Return a chunk (H, 20) from `Policy.forward`'s inputs by name, without the batch axis."""
        feeds = {name: np.asarray(value)[None] for name, value in inputs.items()}
        return self._session.run(None, feeds)[0][0]  # pyright: ignore


def export(policy: Policy) -> bytes:
    """Return the sampler as ONNX, for one chunk at a time."""
    buffer, example = io.BytesIO(), example_inputs(policy.config)
    with warnings.catch_warnings():  # the newer exporter needs a package more, for the same graph
        warnings.simplefilter("ignore")
        torch.onnx.export(
            policy, tuple(example.values()), buffer,  # pyright: ignore[reportArgumentType]
            input_names=list(example),
            output_names=["chunk"], opset_version=OPSET, dynamo=False,
        )  # fmt: skip
    return buffer.getvalue()


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
