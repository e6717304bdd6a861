"""A policy that LeRobot's own command trains for two steps on a made-up dataset with pictures."""

import os
import shutil
import subprocess
from pathlib import Path

import numpy as np

from controller.dataset.merge import merge
from scenarios.demonstration.demonstrate import PARTS
from tests.controller.dataset.episodes import write_parts

TRAIN = shutil.which("lerobot-train")
SMALL = {
    "act": {"policy.dim_model": 64},
    "diffusion": {"policy.down_dims": "[32,64]"},
}


def trained(policy: str, folder: Path, cameras: tuple[str, ...]) -> Path:
    """Return the weights of an "act" or "diffusion" policy."""
    root, out = folder / "filmed", folder / "trained"
    whole = {"expert": np.ones(50, bool), "segment": np.zeros(50, int)}  # as long as a policy needs
    merge(write_parts(root / PARTS, (3,), cameras=cameras, **whole), root)
    options = {
        "dataset.repo_id": "calot/filmed",
        "dataset.root": root,
        "dataset.video_backend": "pyav",
        "policy.type": policy,
        "policy.device": "cpu",
        "policy.push_to_hub": "false",
        "policy.pretrained_backbone_weights": "null",
        "steps": 2,
        "batch_size": 1,
        "num_workers": 0,
        "log_freq": 1,
        "output_dir": out,
        **SMALL[policy],
    }
    words = [str(TRAIN), *(f"--{name}={value}" for name, value in options.items())]
    environment = os.environ | {"HF_HUB_OFFLINE": "1"}
    subprocess.run(words, check=True, env=environment, capture_output=True, timeout=500)
    return next(out.glob("checkpoints/*/pretrained_model/model.safetensors"))
