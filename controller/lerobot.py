"""Run a policy that LeRobot trained on a dataset of `calot collect` as a controller.

The policy's input is the content of such a dataset at one moment: encoders and motor currents, the
pictures of its cameras, and the instruction. A policy that was trained with the sensed tissue also
gets the sensed tissue. The instruction is LeRobot's task in words. LeRobot 0.4 must be installed
beside Calot; its processors normalise input and output.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from controller.action import ACTION_SIZE, Chunk
from controller.dataset.schema import PICTURES, STATE, TISSUE
from controller.diffusion.chunk_frame import motion_of
from planner.instruction import Instruction
from planner.policy_setup import PolicySetup
from tissue_sim.sensing.observation import Observation, encoded_and_tissue

Processor = Callable[[Any], Any]
WEIGHTS = "model.safetensors"


class ControllerLeRobot:
    """Plays as much of each chunk as the policy was made for, or one action at a time.

    One action at a time is played where the policy observes more than one moment. LeRobot's own
    queue keeps these moments.
    """

    def __init__(self, policy: Any, before: Processor, after: Processor) -> None:
        self._policy, self._before, self._after = policy, before, after
        self._text = ""

    def reset(self) -> None:
        """Forget the observations and the rest of the chunk."""
        self._policy.reset()

    def act(self, observation: Observation, instruction: Instruction) -> Chunk:
        """Return the next motions."""
        if instruction.text != self._text:
            self._text = instruction.text
            self._policy.reset()
        told = self._before(told_of(observation, self._text, self._policy.config.input_features))
        rows = self._after(self._actions(told)).reshape(-1, ACTION_SIZE)
        return tuple(motion_of(row) for row in rows.numpy())

    @torch.inference_mode()
    def _actions(self, told: Any) -> torch.Tensor:
        config = self._policy.config
        if config.n_obs_steps > 1:
            return self._policy.select_action(told)
        return self._policy.predict_action_chunk(told)[:, : config.n_action_steps]


def told_of(observation: Observation, text: str, wanted: Any) -> dict[str, Any]:
    """Return a policy's input at one moment, by LeRobot's names.

    Args:
        observation: The present observation.
        text: Text of the instruction.
        wanted: Names of the inputs that the policy was trained with.

    Raises:
        ValueError: The policy wants an input that a robot does not have, or a missing picture.
    """
    vector = observation.vector()[None]
    encoded, tissue = encoded_and_tissue(vector)
    told: dict[str, Any] = {"task": text}
    for name in wanted:
        if name == STATE:
            told[name] = torch.from_numpy(encoded[0].copy())
        elif name == TISSUE:
            told[name] = torch.from_numpy(tissue[0].copy())
        elif name.startswith(PICTURES):
            told[name] = _picture(observation, name.removeprefix(PICTURES))
        else:
            raise ValueError(f"LeRobot's policy wants {name!r}, which a robot is not told")
    return told


def _picture(observation: Observation, camera: str) -> torch.Tensor:
    """Return a picture (3, height, width), 0 to 1."""
    drawn: NDArray[np.uint8] | None = observation.images.get(camera)
    if drawn is None:
        raise ValueError(f"LeRobot's policy was trained with {camera}: name it with --cameras")
    return torch.from_numpy(drawn.copy()).permute(2, 0, 1).float() / 255.0


def make(setup: PolicySetup) -> ControllerLeRobot:
    """Return the controller of a `model.safetensors` in a folder that LeRobot saved.

    Raises:
        ValueError: LeRobot is not installed, no such checkpoint is named, or a camera is missing.
    """
    folder = _folder(setup.checkpoint)
    try:
        factory = import_module("lerobot.policies.factory")
        configs = import_module("lerobot.configs.policies")
    except ImportError as error:
        raise ValueError(f"controller.lerobot: LeRobot is not installed here: {error}") from None
    config = configs.PreTrainedConfig.from_pretrained(folder)
    config.device = "cpu"
    policy = factory.get_policy_class(config.type).from_pretrained(folder, config=config)
    wanted = [name for name in config.input_features if name.startswith(PICTURES)]
    setup.require_cameras("controller.lerobot", [n.removeprefix(PICTURES) for n in wanted])
    torch.manual_seed(setup.seed)
    before, after = factory.make_pre_post_processors(config, str(folder))
    return ControllerLeRobot(policy.eval(), before, after)


def _folder(checkpoint: str | Path | None) -> Path:
    """Return the folder that LeRobot saved, from the path of its `model.safetensors`."""
    if checkpoint is None:
        raise ValueError("controller.lerobot: name the policy's model.safetensors by --checkpoint")
    path = Path(checkpoint)
    if path.name != WEIGHTS or not path.is_file() or not (path.parent / "config.json").is_file():
        raise ValueError(
            f"controller.lerobot: --checkpoint {path}: allowed: a {WEIGHTS} beside its config.json,"
            " as LeRobot saves them"
        )
    return path.parent
