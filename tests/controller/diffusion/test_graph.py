"""Tests of the graph that comes with Calot: it is the policy's, and spares a start the tracing."""

import numpy as np
import pytest

from controller.diffusion import graph
from controller.diffusion.graph import Sampler, example_inputs, traced
from controller.diffusion.policy import CHECKPOINTS, Policy


@pytest.fixture(scope="module")
def policy() -> Policy:
    return CHECKPOINTS.load()


def test_the_graph_that_comes_with_calot_samples_as_one_traced_now(policy, monkeypatch, tmp_path):
    shipped = Sampler(policy)
    anew = tmp_path / "anew.onnx"
    anew.write_bytes(traced(policy))
    monkeypatch.setattr(graph, "SHIPPED", anew)
    now, rng = Sampler(policy), np.random.default_rng(0)
    for n in range(policy.config.max_delay + 1):
        inputs = {
            name: rng.normal(0.0, 0.3, value.shape[1:]).astype(np.float32)
            for name, value in example_inputs(policy.config).items()
        } | {"n_past": np.array(n), "delay": np.array(n)}
        again = "trace it again: python -m controller.diffusion.graph"
        np.testing.assert_array_equal(shipped(inputs), now(inputs), again)


def test_the_checkpoint_that_comes_with_calot_needs_no_tracing(policy, monkeypatch):
    monkeypatch.delattr(graph, "traced")
    Sampler(policy)
