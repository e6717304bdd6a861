"""`Calot-Cholecystectomy-v1`: the world as a ManiSkill environment.

It is the only file that imports ManiSkill. It adds no physics: a step is `World.step`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import gymnasium as gym
import mani_skill.envs  # noqa: F401  first: its modules import each other
import numpy as np
import sapien
import torch
from mani_skill.envs.sapien_env import BaseEnv
from mani_skill.render.shaders import ShaderConfig
from mani_skill.sensors.camera import Camera, CameraConfig
from mani_skill.utils.registration import register_env
from mani_skill.utils.structs.pose import Pose
from mani_skill.utils.structs.types import SceneConfig, SimConfig
from mani_skill.utils.wrappers.gymnasium import CPUGymWrapper

from tissue_sim.frames import Array
from tissue_sim.outcome.predicates import procedure_flags, stumps_hold
from tissue_sim.patient.anatomy import Anatomy, anatomy_from_seed
from tissue_sim.rendering.renderer_probe import renderer_available
from tissue_sim.rendering.shader_pack import (
    COLOR_PICTURE,
    MICROMETRE,
    POSITION_PICTURE,
    set_picture_formats,
    shader_pack,
)
from tissue_sim.saving.state_check import require_names, require_type
from tissue_sim.saving.state_tensors import state_from_tensors, state_to_tensors
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.pictures.cameras import (
    CAMERAS,
    FAR_PLANE_M,
    NEAR_PLANE_M,
    CameraSpec,
    T_world_camera,
)
from tissue_sim.sensing.pictures.segmentation import CLASSES, classes_of_entities
from tissue_sim.tools.arms import RIGHT_ARM, JointCommand
from tissue_sim.tools.instruments import INSTRUMENTS
from tissue_sim.tools.physics_system import physics_system
from tissue_sim.tools.psm import joint_limits
from tissue_sim.world import World, WorldConfig

ENVIRONMENT_ID = "Calot-Cholecystectomy-v1"
MAX_EPISODE_STEPS = 9000  # five minutes
SENSOR_PIXELS = 128
TRAINING_SEEDS = 10_000  # a reset without a seed draws from these
CPU_BACKENDS = ("auto", "cpu", "physx_cpu")
CONTROL_MODE = "joint_targets"
BLIND_MODES = ("state", "state_dict", "none")
PASSING = ("gallbladder grasped",)  # need not hold any more when the procedure is finished


@register_env(ENVIRONMENT_ID, max_episode_steps=MAX_EPISODE_STEPS)
class CholecystectomyEnv(BaseEnv):
    """Clip and cut the cystic duct and the cystic artery.

    Action: (14,) joint targets, left arm then right: yaw, pitch (rad), insertion (m), roll, wrist
    pitch, wrist yaw, jaw (rad). Values beyond the limits are clipped.

    `reset(seed=n)` takes the patient `anatomy_from_seed(n)`, and
    `reset(options={"anatomy": ...})` any other.
    """

    SUPPORTED_REWARD_MODES = ("sparse", "none")
    _UNBATCHED = (14,)

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
        control_mode: str | None = None,
        reconfiguration_freq: int = 1,  # a new scene for each reset: no trace of old contacts
        **kwargs: Any,
    ) -> None:
        _check_backend(num_envs, sim_backend)
        _check_robot(robot_uids, control_mode)
        sim_config = sim_config or {}
        self._world_config = _world_config(sim_config)
        if render_backend is None:
            pictures = obs_mode not in (None, *BLIND_MODES) or render_mode is not None
            render_backend = "gpu" if pictures else "none"
        if render_backend != "none" and not renderer_available():
            raise ValueError(
                f"render_backend = {render_backend!r}: there is no renderer here; use 'none' with "
                f"obs_mode in {BLIND_MODES} (see `calot doctor`)"
            )
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
        low, high = action_limits()
        low, high = low.astype(np.float32), high.astype(np.float32)
        self.single_action_space = gym.spaces.Box(low, high, dtype=np.float32)
        self.action_space = gym.spaces.Box(low[None], high[None], dtype=np.float32)
        self._orig_single_action_space = self.single_action_space

    @property
    def control_mode(self) -> str:
        """The meaning of actions: joint targets."""
        return CONTROL_MODE

    def equip(self, instrument: str) -> None:
        """Mount "clip_applier" (with a clip) or "scissors" on the right arm."""
        self.world.equip(instrument)

    def reset(
        self, seed: int | list[int] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Put in a new patient: `options["anatomy"]`, the seed's, or one drawn for training.

        Raises:
            ValueError: the seed or the anatomy is none; nothing is changed.
        """
        first = _first(seed)
        anatomy = (options or {}).get("anatomy")
        if anatomy is not None:
            require_type(anatomy, Anatomy, "options['anatomy']")
        elif first is not None:
            anatomy = anatomy_from_seed(first)
        gym.Env.reset(self, seed=first)
        self._anatomy = anatomy or anatomy_from_seed(int(self.np_random.integers(TRAINING_SEEDS)))
        return super().reset(seed=None if first is None else [first], options=options)

    def evaluate(self) -> dict[str, torch.Tensor]:
        """Return what of the procedure is done. Success: all of it, and every stump is closed."""
        flags = procedure_flags(self.world)
        done = all(v for name, v in flags.items() if name not in PASSING)
        flags["success"] = done and stumps_hold(self.world)
        return {name.replace(" ", "_"): torch.tensor([value]) for name, value in flags.items()}

    def compute_sparse_reward(
        self, obs: Any, action: torch.Tensor, info: dict[str, Any]
    ) -> torch.Tensor:
        """Return one when the procedure is done, else zero."""
        return info["success"].float()

    def get_state_dict(self) -> dict[str, torch.Tensor]:
        """Return everything the next step depends on: tissue topology, arms, clips, patient."""
        return state_to_tensors({"anatomy": self.world.anatomy, "world": self.world.state()})

    def set_state_dict(self, state: dict[str, Any], env_idx: torch.Tensor | None = None) -> None:
        """Put back what `get_state_dict` returned, of this patient or another.

        Raises:
            ValueError: it is not such a state; nothing is changed.
        """
        whole = state_from_tensors(state)
        require_type(whole, dict, "state")
        require_names(set(whole), {"anatomy", "world"}, "state")
        require_type(whole["anatomy"], Anatomy, "state/anatomy")
        self.world.check(whole["world"], whole["anatomy"])
        if whole["anatomy"] != self.world.anatomy:
            self.world.reset(whole["anatomy"])
        self.world.restore(whole["world"])
        self._observation, self._targets = self.world.observe(), self.world.target

    def get_state(self) -> torch.Tensor:
        """Return the state's bytes (1, n)."""
        parts = [v.numpy().reshape(-1).view(np.uint8) for v in self.get_state_dict().values()]
        return torch.from_numpy(np.concatenate(parts))[None]

    def set_state(self, state: torch.Tensor, env_idx: torch.Tensor | None = None) -> None:
        """Put back what `get_state` returned, of this patient.

        Raises:
            ValueError: it is not bytes, of another size, or damaged; nothing is changed.
        """
        data = np.asarray(state).reshape(-1)
        if data.dtype != np.uint8:
            raise ValueError(f"state: it is of {data.dtype}; expected: uint8")
        own = {k: v.numpy() for k, v in self.get_state_dict().items()}
        if data.size != sum(v.nbytes for v in own.values()):
            raise ValueError(f"state: {data.size} bytes, not of this patient: use set_state_dict")
        ends = np.cumsum([v.nbytes for v in own.values()])
        tensors = {
            name: torch.from_numpy(piece.copy().view(v.dtype).reshape(v.shape))
            for (name, v), piece in zip(own.items(), np.split(data, ends[:-1]), strict=True)
        }
        self.set_state_dict(tensors)

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
        """Set the simulator's settings as for a world without ManiSkill."""
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
        """One control step of the world; without an action, to the last targets."""
        if action is not None:
            self._targets = self._checked(action).reshape(2, 7)
        self._observation = self.world.step(JointCommand(joints=self._targets))
        return None if action is None else torch.from_numpy(self._targets.reshape(1, 14)).float()

    def _checked(self, action: Any) -> Array:
        values = action.cpu().numpy() if isinstance(action, torch.Tensor) else np.asarray(action)
        if values.shape not in (self._UNBATCHED, (1, *self._UNBATCHED)):
            raise ValueError(f"action: its shape is {values.shape}, allowed: (14,) or (1, 14)")
        if not np.isfinite(values).all():
            raise ValueError(f"action: it must be (14,) finite numbers, got {values.tolist()}")
        low, high = action_limits()
        return np.clip(values.reshape(-1).astype(float), low, high)

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
            "scissors": _row([now.tools[RIGHT_ARM] == "scissors"]),
        }
        return extra | _exact_tissue(now) if self.obs_mode_struct.use_state else extra

    def _get_obs_sensor_data(self, apply_texture_transforms: bool = True) -> dict[str, Any]:
        self._draw(self._sensors)
        return super()._get_obs_sensor_data(apply_texture_transforms)

    def render(self) -> Any:
        """Draw the endoscope's left picture (1, height, width, 3), or what `render_mode` names."""
        self._draw(self._human_render_cameras)
        return super().render()

    def _draw(self, cameras: dict[str, Any]) -> None:
        """Draw the field as it is now, and place the cameras."""
        if self.world.view is None:
            raise ValueError("render_backend is 'none': choose another to see anything")
        self.world.view.update(self.world)
        self._classes = classes_of_entities(self.world.scene)
        for uid, camera in cameras.items():
            if isinstance(camera, Camera):
                name = CAMERAS[0].name if uid == "render_camera" else uid
                T = sapien.Pose(T_world_camera(self.world, name))
                camera.camera._render_cameras[0].entity.set_pose(T)


def make_single(**options: Any) -> gym.Env:
    """Make one environment, with numpy arrays without a batch axis."""
    return CPUGymWrapper(gym.make(ENVIRONMENT_ID, **options))


def action_limits() -> tuple[Array, Array]:
    """Return the lowest and highest joint targets (14,), over all tools of each arm."""
    right = [INSTRUMENTS["clip_applier"], INSTRUMENTS["scissors"]]
    arms = ([INSTRUMENTS["grasper"]], right)
    limits = [
        np.stack([np.vstack([joint_limits(t), t.jaw_range_rad]) for t in tools]) for tools in arms
    ]
    low = np.concatenate([tools[:, :, 0].min(axis=0) for tools in limits])
    high = np.concatenate([tools[:, :, 1].max(axis=0) for tools in limits])
    return low, high


def _first(seed: int | Iterable[int] | None) -> int | None:
    """Return the seed of the only environment, which ManiSkill gives in a list."""
    if not isinstance(seed, Iterable):
        return seed
    seeds = list(seed)
    if len(seeds) != 1:
        raise ValueError(f"seed = {seed!r} must be a number, or a list of one")
    return int(seeds[0])


def _check_robot(robot_uids: str, control_mode: str | None) -> None:
    if robot_uids != "none":
        raise ValueError(f"robot_uids = {robot_uids!r}: its two arms are part of it; leave it out")
    if control_mode not in (None, CONTROL_MODE):
        raise ValueError(f"control_mode = {control_mode!r}: only {CONTROL_MODE!r}")


def _check_backend(num_envs: int, sim_backend: str) -> None:
    if num_envs != 1:
        raise ValueError(f"num_envs = {num_envs}: only 1; use gymnasium's vector environments")
    if sim_backend not in CPU_BACKENDS:
        raise ValueError(f"sim_backend = {sim_backend!r}: choose from {CPU_BACKENDS}")


def _world_config(sim_config: SimConfig | dict[str, Any]) -> WorldConfig:
    """Convert ManiSkill's frequencies to periods.

    Raises:
        ValueError: one does not divide the next.
    """
    given = sim_config if isinstance(sim_config, dict) else sim_config.dict()
    own = WorldConfig()
    control_hz = given.get("control_freq", round(1.0 / own.control_step_s))
    sim_hz = given.get("sim_freq", round(1.0 / own.physics_step_s))
    tissue_hz = round(1.0 / own.tissue.step_s)
    if min(control_hz, sim_hz) <= 0 or sim_hz % tissue_hz or tissue_hz % control_hz:
        raise ValueError(
            f"control_freq = {control_hz}, sim_freq = {sim_hz}: control_freq must divide "
            f"{tissue_hz} Hz, the tissue's rate, and that must divide sim_freq"
        )
    return WorldConfig(control_step_s=1.0 / control_hz, physics_step_s=1.0 / sim_hz)


def _exact_tissue(now: Observation) -> dict[str, torch.Tensor]:
    return {
        "left_tube_m": _row(now.left_tube_m),
        "right_tube_m": _row(now.right_tube_m),
        "sac_m": _row(now.sac_m),
        "clips_m": _row(now.clips_m),
        "n_clips": _row([now.n_clips]),
        "severed": _row(now.severed),
    }


def _row(values: Any) -> torch.Tensor:
    """Convert to a float32 row (1, n)."""
    return torch.from_numpy(np.asarray(values, np.float32).reshape(1, -1).copy())


def _rgb(picture: torch.Tensor) -> dict[str, torch.Tensor]:
    return {"rgb": picture[..., :3]}
