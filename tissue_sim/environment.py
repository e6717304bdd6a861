"""Wrap the world as a ManiSkill environment, `Calot-Cholecystectomy-v1`.

No other file imports ManiSkill. The environment adds no physics: a step is `World.step`.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import gymnasium as gym
import mani_skill.envs  # noqa: F401  first: its modules import each other
import numpy as np
import sapien
import torch
from gymnasium.envs.registration import EnvSpec, WrapperSpec
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.render.shaders import ShaderConfig
from mani_skill.sensors.camera import Camera, CameraConfig
from mani_skill.utils.registration import register
from mani_skill.utils.structs.pose import Pose
from mani_skill.utils.structs.types import SceneConfig, SimConfig
from mani_skill.utils.wrappers.gymnasium import CPUGymWrapper

from tissue_sim.control_modes import JOINT_TARGETS, action_limits, read_action
from tissue_sim.environment_options import (
    BLIND_MODES,
    first_seed,
    render_modes,
    require_backend,
    require_renderer,
    require_reset_options,
    require_robot,
    world_config,
)
from tissue_sim.outcome import nurse
from tissue_sim.outcome.predicates import procedure_flags, stumps_hold
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.rendering.shader_pack import (
    COLOR_PICTURE,
    MICROMETRE,
    POSITION_PICTURE,
    set_picture_formats,
    shader_pack,
)
from tissue_sim.sensing.cameras import (
    CAMERAS,
    FAR_PLANE_M,
    NEAR_PLANE_M,
    CameraSpec,
    T_world_camera,
)
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.segmentation import CLASSES, classes_of_entities
from tissue_sim.state_tensors import flat, state_from_tensors, state_to_tensors
from tissue_sim.tools.arms import JointCommand
from tissue_sim.tools.drives import physics_system
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.world import World, WorldConfig

ENVIRONMENT_ID = "Calot-Cholecystectomy-v1"
MAX_EPISODE_STEPS = 9000  # five minutes
SENSOR_PIXELS = 128
TRAINING_SEEDS = 10_000  # a reset without a seed draws from these
PASSING = ("gallbladder grasped",)  # may be false again when the procedure is finished


class CholecystectomyEnv(BaseEnv):
    """Clip and cut the cystic duct and the cystic artery.

    Action: (14,) joint targets, left arm then right: yaw, pitch (rad), insertion (m), roll, wrist
    pitch, wrist yaw, jaw (rad). Values beyond the mounted tools' limits are clipped. With
    `control_mode="joint_targets_and_tool"`, a 15th number requests the right arm's tool.

    `reset(seed=n)` loads the patient `anatomy_from_seed(n)`. `reset(options={"anatomy": ...})`
    loads any other patient.
    """

    SUPPORTED_REWARD_MODES = ("sparse", "none")
    _spec: EnvSpec | None = None

    def __init__(
        self,
        *args: Any,
        num_envs: int = 1,
        obs_mode: str | None = None,
        render_mode: str | None = None,
        sim_backend: str = "auto",
        render_backend: str | None = None,
        sim_config: SimConfig | dict[str, Any] | None = None,
        robot_uids: str = "none",
        control_mode: str | None = JOINT_TARGETS,
        reconfiguration_freq: int = 1,  # a new scene for each reset: no trace of old contacts
        **kwargs: Any,
    ) -> None:
        control_mode = control_mode or JOINT_TARGETS
        require_backend(num_envs, sim_backend)
        require_robot(robot_uids, control_mode)
        sim_config = sim_config or {}
        given = sim_config if isinstance(sim_config, dict) else sim_config.dict()
        self._world_config = world_config(given)
        if render_backend is None:
            pictures = obs_mode not in (None, *BLIND_MODES) or render_mode is not None
            render_backend = "gpu" if pictures else "none"
        require_renderer(render_backend)
        self._mode = control_mode
        with _told_if_no_window(render_mode):
            super().__init__(
                *args,
                num_envs=num_envs,
                obs_mode=obs_mode,
                render_mode=render_mode,
                sim_backend="physx_cpu",
                render_backend=render_backend,
                sim_config=sim_config,
                robot_uids=robot_uids,
                reconfiguration_freq=reconfiguration_freq,
                **kwargs,
            )
        low, high = action_limits(control_mode)
        self.single_action_space = gym.spaces.Box(low, high, dtype=np.float32)
        self.action_space = gym.spaces.Box(low[None], high[None], dtype=np.float32)
        self._orig_single_action_space = self.single_action_space

    @property
    def metadata(self) -> dict[str, Any]:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the render modes that work on this machine, and the pictures per second."""
        return {"render_modes": render_modes(), "render_fps": self.control_freq}

    @property
    def spec(self) -> EnvSpec | None:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the specification from which gymnasium makes the environment again.

        Its identifier names this module, so that gymnasium imports the module.
        """
        return self._spec

    @spec.setter
    def spec(self, spec: EnvSpec) -> None:
        self._spec = replace(spec, id=f"{__name__}:{ENVIRONMENT_ID}")

    @property
    def control_mode(self) -> str:
        """Return the meaning of actions, one of `control_modes.N_NUMBERS`."""
        return self._mode

    def equip(self, instrument: str) -> None:
        """Mount "clip_applier" (with a clip) or "scissors" on the right arm, without an action."""
        self.world.equip(instrument)
        self._observation = self.world.observe()

    def reset(
        self, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Load a patient: `options["anatomy"]`, the seed's, or a patient drawn for training.

        Args:
            seed: the patient's seed.
            options: `anatomy` is an `Anatomy` or the dict of its fields. ManiSkill's own option
                `reset_to_env_states` starts from `{"env_states": ...}`.

        Raises:
            ValueError: the seed or an option is invalid; nothing is changed.
        """
        first, given = first_seed(seed), require_reset_options(options)
        states = given.pop("reset_to_env_states", {}).get("env_states")
        whole = None if states is None else self._opened(states)
        anatomy = whole["anatomy"] if whole else given.get("anatomy")
        if anatomy is None and first is not None:
            anatomy = anatomy_from_seed(first)
        gym.Env.reset(self, seed=first)
        if anatomy is None:  # ManiSkill records the seed: a replay finds the same patient
            first = int(self.np_random.integers(TRAINING_SEEDS))
            anatomy = anatomy_from_seed(first)
        self._anatomy = anatomy
        obs, info = super().reset(seed=None if first is None else [first], options=given)
        return (obs, info) if whole is None else self._started_from(whole, info)

    def _started_from(
        self, whole: dict[str, Any], info: dict[str, Any]
    ) -> tuple[Any, dict[str, Any]]:
        """Continue from a checked state after a reset to its patient."""
        self._put_back(whole)
        info = info | self.get_info()
        self._last_obs = self.get_obs(info)
        return self._last_obs, info

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Return which parts of the procedure are done.

        Success means that all parts are done and every stump is closed.
        """
        flags = procedure_flags(self.world)
        done = all(v for name, v in flags.items() if name not in PASSING)
        flags["success"] = done and stumps_hold(self.world)
        return {name.replace(" ", "_"): torch.tensor([value]) for name, value in flags.items()}

    def compute_sparse_reward(
        self, obs: Any, action: torch.Tensor, info: dict[str, Any]
    ) -> torch.Tensor:
        """Return one when the procedure is done, else zero."""
        return info["success"].float()

    def get_state_dict(self) -> dict[str, Any]:
        """Return all that the next step depends on: tissue topology, arms, clips, patient."""
        return state_to_tensors({"anatomy": self.world.anatomy, "world": self.world.state()})

    def set_state_dict(self, state: dict[str, Any], env_idx: torch.Tensor | None = None) -> None:
        """Restore a state, of any patient, from `get_state_dict` or `RecordEpisode`.

        Raises:
            ValueError: the value is not such a state; nothing is changed.
        """
        whole = self._opened(state)
        if whole["anatomy"] != self.world.anatomy:
            self.world.reset(whole["anatomy"])
        self._put_back(whole)

    def _opened(self, state: Any) -> dict[str, Any]:
        """Return a checked state as `{"anatomy": ..., "world": ...}`, from a state or its bytes."""
        in_bytes = isinstance(state, torch.Tensor | np.ndarray)
        whole = state_from_tensors(self._unflattened(state) if in_bytes else state)
        self.world.check(whole["world"], whole["anatomy"])
        return whole

    def _put_back(self, whole: dict[str, Any]) -> None:
        self.world.restore(whole["world"])
        self._observation, self._targets = self.world.observe(), self.world.target

    def get_state(self) -> torch.Tensor:
        """Return the state's bytes (1, n)."""
        parts = [v.numpy().reshape(-1).view(np.uint8) for v in flat(self.get_state_dict()).values()]
        return torch.from_numpy(np.concatenate(parts))[None]

    def set_state(self, state: torch.Tensor, env_idx: torch.Tensor | None = None) -> None:
        """Restore the bytes that `get_state` returned, of this patient.

        Raises:
            ValueError: the value is not bytes, has another size, or is damaged; nothing is changed.
        """
        self.set_state_dict(self._unflattened(state))

    def _unflattened(self, state: Any) -> dict[str, Any]:
        data = np.asarray(state).reshape(-1)
        if data.dtype != np.uint8:
            raise ValueError(f"state: it is of {data.dtype}; expected: uint8")
        own = {k: v.numpy() for k, v in flat(self.get_state_dict()).items()}
        if data.size != sum(v.nbytes for v in own.values()):
            raise ValueError(f"state: {data.size} bytes, not of this patient: use set_state_dict")
        pieces = np.split(data, np.cumsum([v.nbytes for v in own.values()])[:-1])
        return {
            name: piece.copy().view(v.dtype).reshape(v.shape)
            for (name, v), piece in zip(own.items(), pieces, strict=True)
        }

    def segmentation_names(self) -> dict[int, str]:
        """Return the class that each number of a segmentation image means."""
        return dict(enumerate(CLASSES))

    @property
    def _default_sim_config(self) -> SimConfig:
        return SimConfig(
            sim_freq=round(1.0 / WorldConfig().physics_step_s),
            control_freq=round(1.0 / WorldConfig().control_step_s),
            scene_config=SceneConfig(),
        )

    @property
    def _default_sensor_configs(self) -> list[CameraConfig]:
        return [self._camera_config(spec, spec.name, SENSOR_PIXELS) for spec in CAMERAS]

    @property
    def _default_human_render_camera_configs(self) -> list[CameraConfig]:
        return [self._camera_config(CAMERAS[0], "render_camera", None)]

    def _camera_config(self, spec: CameraSpec, uid: str, pixels: int | None) -> CameraConfig:
        return CameraConfig(
            uid=uid,
            pose=Pose.create(sapien.Pose()),
            width=pixels or spec.width,
            height=pixels or spec.height,
            fov=spec.fov_rad,
            near=NEAR_PLANE_M,
            far=FAR_PLANE_M,
            shader_config=ShaderConfig(
                shader_pack=str(shader_pack()),
                texture_names={
                    COLOR_PICTURE: ["rgb"],
                    POSITION_PICTURE: ["position", "depth", "segmentation"],
                },
                texture_transforms={COLOR_PICTURE: _rgb, POSITION_PICTURE: self._geometry},
            ),
        )

    def _geometry(self, picture: torch.Tensor) -> dict[str, torch.Tensor]:
        """Return positions and depth in metres (float32), and each pixel's class (int16)."""
        classes = torch.from_numpy(self._classes)[picture[..., [3]].long()]
        return {
            "position": picture[..., :3] * MICROMETRE,
            "depth": -picture[..., [2]] * MICROMETRE,
            "segmentation": classes.to(torch.int16),
        }

    def _set_scene_config(self) -> None:
        """Set the simulator's settings to those of a world without ManiSkill."""
        physics_system()  # for the whole process

    def _load_agent(self, options: dict[str, Any], *args: Any, **kwargs: Any) -> None:
        self.agent = None  # the arms belong to the world  # pyright: ignore

    def _load_scene(self, options: dict[str, Any]) -> None:
        self.world = World(
            self.scene.sub_scenes[0], render=self.scene.can_render(), config=self._world_config
        )

    def _load_lighting(self, options: dict[str, Any]) -> None:
        """Load nothing: the world's view has its own lamp."""

    def _setup_sensors(self, options: dict[str, Any]) -> None:
        set_picture_formats()
        super()._setup_sensors(options)

    def _initialize_episode(self, env_idx: torch.Tensor, options: dict[str, Any]) -> None:
        self._observation = self.world.reset(self._anatomy)
        self._targets = self._observation.joints

    def _step_action(self, action: Any) -> torch.Tensor | None:
        """Advance the world by one control step; without an action, towards the last targets."""
        if action is not None:
            asked = read_action(action, self.control_mode)
            clip = asked.tool is not None and INSTRUMENTS[asked.tool].deed == "clip"
            if asked.tool and nurse.is_needed(self._observation, asked.tool, clip=clip):
                self.equip(asked.tool)
            self._targets = asked.joints
        self._targets = self.world.arms.limited(self._targets)
        self._observation = self.world.step(JointCommand(joints=self._targets))
        return None if action is None else torch.from_numpy(self._targets.reshape(1, 14)).float()

    def _get_obs_agent(self) -> dict[str, torch.Tensor]:
        velocities = self.world.arms.joint_velocities
        return {"qpos": _row(self._observation.joints), "qvel": _row(velocities)}

    def _get_obs_extra(self, info: dict[str, Any]) -> dict[str, torch.Tensor]:
        """Return the tools' values; in the state modes, add the exact state of the tissue."""
        now = self._observation
        extra = {
            "tips_endoscope": _row(now.tips_endoscope[:, :3]),
            "forces_n": _row(now.forces_n),
            "clip_loaded": _row([now.clip_loaded]),
            "right_tool": _row(now.right_tool),
        }
        return extra | _exact_tissue(now) if self.obs_mode_struct.use_state else extra

    def _get_obs_sensor_data(self, apply_texture_transforms: bool = True) -> dict[str, Any]:
        self._draw(self._sensors)
        return super()._get_obs_sensor_data(apply_texture_transforms)

    def render(self) -> Any:
        """Draw the endoscope's left picture (1, height, width, 3), or the view of `render_mode`."""
        self._draw(self._human_render_cameras)
        return super().render()

    def _draw(self, cameras: dict[str, Any]) -> None:
        """Draw the current field, and place the cameras."""
        if self.world.view is None:
            raise ValueError("render_backend is 'none': choose another to see anything")
        self.world.view.update(self.world)
        self._classes = classes_of_entities(self.world.scene)
        for uid, camera in cameras.items():
            if isinstance(camera, Camera):
                name = CAMERAS[0].name if uid == "render_camera" else uid
                T = sapien.Pose(T_world_camera(self.world, name))
                camera.camera._render_cameras[0].entity.set_pose(T)


class BatchedTruncation(gym.Wrapper, gym.utils.RecordConstructorArgs):
    """Adds a batch axis, as other results have, to the one bool of gymnasium's `TimeLimit`."""

    def __init__(self, env: gym.Env) -> None:
        gym.utils.RecordConstructorArgs.__init__(self)
        gym.Wrapper.__init__(self, env)

    def step(self, action: Any) -> Any:
        observation, reward, terminated, truncated, info = self.env.step(action)
        return observation, reward, terminated, torch.as_tensor(truncated).reshape(1), info


class Unbatched(gym.utils.RecordConstructorArgs, CPUGymWrapper):
    """Returns NumPy arrays without a batch axis, and plain numbers."""

    def __init__(self, env: gym.Env) -> None:
        gym.utils.RecordConstructorArgs.__init__(self)
        CPUGymWrapper.__init__(self, env)


def make_single(**options: Any) -> gym.Env:
    """Make one environment whose NumPy arrays have no batch axis, as most libraries expect.

    Args:
        options: options of `gym.make`, such as `obs_mode`.
    """
    return Unbatched(gym.make(ENVIRONMENT_ID, **options))


@contextmanager
def _told_if_no_window(render_mode: str | None) -> Iterator[None]:
    """Raise an error with advice where the viewer's window cannot be opened."""
    try:
        yield
    except RuntimeError as error:
        if render_mode != "human":
            raise
        raise ValueError(
            f"render_mode = 'human': no window can be opened here ({error}); use 'rgb_array', "
            "or watch episodes in a browser with `calot view`"
        ) from error


def _exact_tissue(now: Observation) -> dict[str, torch.Tensor]:
    names = ("tubes_m", "third_tube", "sac_m", "clips_m", "n_clips", "severed")
    return {name: _row(getattr(now, name)) for name in names}


def _row(values: Any) -> torch.Tensor:
    """Convert to a float32 row (1, n)."""
    return torch.from_numpy(np.asarray(values, np.float32).reshape(1, -1).copy())


def _rgb(picture: torch.Tensor) -> dict[str, torch.Tensor]:
    return {"rgb": picture[..., :3]}


register(ENVIRONMENT_ID, CholecystectomyEnv, max_episode_steps=MAX_EPISODE_STEPS)
gym.register(
    ENVIRONMENT_ID,
    entry_point=f"{__name__}:CholecystectomyEnv",
    max_episode_steps=MAX_EPISODE_STEPS,
    disable_env_checker=True,  # it expects arrays without a batch axis
    additional_wrappers=(
        WrapperSpec(BatchedTruncation.__name__, f"{__name__}:BatchedTruncation", {}),
    ),
)
