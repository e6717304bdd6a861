"""LeRobot's diffusion policy, for a comparison with Calot's."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version

import torch

from controller.action import ACTION_SIZE
from tissue_sim.sensing.observation import VECTOR_SIZE

NOT_INSTALLED = (
    "LeRobot is not installed; to compare with it: .venv/bin/pip install -e '.[lerobot]'"
)


def lerobot_version() -> str | None:
    """Return LeRobot's version; None if it is not installed."""
    try:
        return version("lerobot")
    except PackageNotFoundError:
        return None


def lerobot_chunk() -> Callable[[], torch.Tensor]:
    """Return a function that samples one chunk with LeRobot's settings, without images (0.4.4)."""
    from lerobot.configs.types import FeatureType, PolicyFeature  # pyright: ignore
    from lerobot.policies.diffusion.configuration_diffusion import DiffusionConfig  # pyright: ignore
    from lerobot.policies.diffusion.modeling_diffusion import DiffusionPolicy  # pyright: ignore

    shape = (VECTOR_SIZE,)
    config = DiffusionConfig(
        input_features={
            "observation.state": PolicyFeature(FeatureType.STATE, shape),
            "observation.environment_state": PolicyFeature(FeatureType.ENV, shape),
        },
        output_features={"action": PolicyFeature(FeatureType.ACTION, (ACTION_SIZE,))},
        device="cpu",
    )
    policy = DiffusionPolicy(config).eval()
    seen = {name: torch.zeros(1, config.n_obs_steps, *shape) for name in config.input_features}
    return torch.inference_mode()(lambda: policy.diffusion.generate_actions(seen))
