"""Run a policy's sampler as an ONNX Runtime graph: the same chunks, much faster than eager.

A graph has no weights, so that all policies of a configuration share it. To trace one takes a
second, so the graph of the default configuration comes with Calot. This command traces it again
after a change of networks or features: `python -m controller.diffusion.graph`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from controller.action import ACTION_SIZE
from controller.diffusion.command import TOKEN_SIZE
from controller.diffusion.config import WORDS_SIZE, PolicyConfig
from controller.diffusion.policy import Policy
from planner.learning.onnx_graph import OnnxGraph, export
from tissue_sim.sensing.observation import VECTOR_SIZE

SHIPPED = Path(__file__).with_name("policy.onnx")  # of `PolicyConfig()`


class Sampler:
    """Samples one chunk at a time."""

    def __init__(self, policy: Policy) -> None:
        graph = SHIPPED.read_bytes() if policy.config == PolicyConfig() else traced(policy)
        self._graph = OnnxGraph(graph, policy.state_dict())

    def __call__(self, inputs: Mapping[str, NDArray]) -> NDArray[np.float32]:
        """Return a chunk (H, 20) from `Policy.forward`'s inputs by name, without the batch axis."""
        return self._graph.run(inputs)[0]


def traced(policy: Policy) -> bytes:
    """Trace the sampler as ONNX, for one chunk at a time and without weights."""
    return export(policy, example_inputs(policy.config), ["chunk"], with_weights=False)


def example_inputs(config: PolicyConfig) -> dict[str, Tensor]:
    """Return inputs of `Policy.forward` by name, of the right shapes."""
    none = torch.zeros(1, dtype=torch.int64)
    return {
        "history": torch.zeros(1, len(config.history), VECTOR_SIZE),
        "jaw_rad": torch.zeros(1, 2),
        "words": torch.zeros(1, 2, WORDS_SIZE),
        "token": torch.zeros(1, TOKEN_SIZE),
        "past": torch.zeros(1, config.past, ACTION_SIZE),
        "n_past": none,
        "delay": none.clone(),
        "noise": torch.zeros(1, config.horizon, ACTION_SIZE),
    }


if __name__ == "__main__":
    SHIPPED.write_bytes(traced(Policy(PolicyConfig()).eval()))
