"""Simulate the world: an operating field in time, with two arms and one patient's tissue."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

import numpy as np
import sapien
from numpy.typing import NDArray

from tissue_sim.constants import CONTROL_PERIOD_S, WORLD_VERSION
from tissue_sim.field import Field
from tissue_sim.frames import Array, endoscope_pose
from tissue_sim.mechanics.step import TissueConfig
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.anatomy import Anatomy
from tissue_sim.patient.body import Body
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import build_organ
from tissue_sim.patient.sac import Sac
from tissue_sim.patient.tubes import Tubes
from tissue_sim.sensing.exact import exact_observation
from tissue_sim.sensing.observation import Observation
from tissue_sim.surgery.clip import Clip, dropped_clip, grip_n
from tissue_sim.surgery.clip_bar import place_bars
from tissue_sim.surgery.clip_slip import Pull
from tissue_sim.surgery.events import record_step
from tissue_sim.surgery.record import Conditions, Record
from tissue_sim.tools.arms import HOME_JOINTS, RIGHT_ARM, Arms, JointCommand
from tissue_sim.tools.drives import physics_system
from tissue_sim.tools.instruments import CLIP_APPLIER, INSTRUMENTS, clip_of
from tissue_sim.world_state import copied, require_state

SETTLE_STEPS = 45
_NO_WRENCHES = (np.zeros((8, 3), np.float32), np.zeros((8, 3), np.float32))


@dataclass(frozen=True, kw_only=True)
class WorldConfig:
    """Periods of the loop, s. Each is a whole multiple of the next shorter one."""

    control_step_s: float = CONTROL_PERIOD_S
    physics_step_s: float = 1.0 / 120.0
    tissue: TissueConfig = field(default_factory=TissueConfig)

    def __post_init__(self) -> None:
        for name, coarse, fine in (
            ("control_step_s", self.control_step_s, self.tissue.step_s),
            ("tissue.step_s", self.tissue.step_s, self.physics_step_s),
        ):
            if whole_multiple(coarse, fine) is None:
                raise ValueError(f"world: {name} = {coarse} must be a multiple of {fine} s")


def whole_multiple(coarse_s: float, fine_s: float) -> int | None:
    """Return the number of fine steps in a coarse step, or None if it is not a whole number."""
    count = round(coarse_s / fine_s) if fine_s > 0 and isfinite(coarse_s) else 0
    return count if count > 0 and abs(count * fine_s - coarse_s) < 1e-9 else None


class World(Field):
    """A field in time: `reset` loads a patient, `step` advances by one control period.

    Before the first `reset`, the field contains only the arms. A method that needs a patient then
    raises a ValueError.
    """

    def __init__(
        self,
        scene: sapien.Scene | None = None,
        *,
        render: bool = False,
        config: WorldConfig | None = None,
    ) -> None:
        from tissue_sim.rendering.view import FieldCameras, renderable_scene

        self.config = config or WorldConfig()
        self.scene = scene or (renderable_scene() if render else sapien.Scene([physics_system()]))
        self.scene.set_timestep(self.config.physics_step_s)
        self.arms = Arms(self.scene, render=render)
        self._rigid: tuple[sapien.Entity, ...] = ()
        per_control = whole_multiple(self.config.control_step_s, self.config.tissue.step_s) or 0
        per_tissue = whole_multiple(self.config.tissue.step_s, self.config.physics_step_s) or 0
        shares = np.linspace(0.0, 1.0, per_control * per_tissue + 1)[1:]
        self._shares = shares.reshape(per_control, per_tissue)  # shares of the way to the target
        self.wrenches = _NO_WRENCHES
        self.view = FieldCameras(self.scene) if render else None

    def reset(self, anatomy: Anatomy) -> Observation:
        """Load a new patient, move the instruments home and let the tissue come to rest.

        Raises:
            ValueError: the value is no patient, or cannot be meshed; nothing is changed.
            ArithmeticError: the tissue does not stay finite.
        """
        if not isinstance(anatomy, Anatomy):
            raise ValueError(
                f"world: anatomy = {anatomy!r} must be an Anatomy, such as anatomy_from_seed(0)"
            )
        tissue, tubes = self._prepare(anatomy)
        self.anatomy, self.tissue, self.tubes = anatomy, tissue, tubes
        self._barred: tuple[Clip, ...] = ()
        self.organ = self.tubes.organ
        self.sac = Sac(self.tissue, self.organ)
        self.T_world_endoscope = endoscope_pose(
            anatomy.endoscope_pitch_rad, anatomy.endoscope_yaw_rad, anatomy.endoscope_distance_m
        )
        for entity in self._rigid:
            self.scene.remove_entity(entity)
        self.body = Body(self.scene, self.tissue, self.organ)
        self._rigid = self.body.rigid
        self.conditions = Conditions()
        self.arms.mount(CLIP_APPLIER)
        self.arms.set_joints(np.tile(HOME_JOINTS, (2, 1)))
        self._target = self.arms.joints
        self.wrenches = _NO_WRENCHES
        self._place_tools()
        for _ in range(SETTLE_STEPS):
            self._step_tissue(time_s=0.0)
        self.record = Record(bed_rest_n=self.bed_press_n())
        return self.observe()

    def step(self, command: JointCommand, *, intended: str | None = None) -> Observation:
        """Advance by one control period.

        Args:
            command: joint targets.
            intended: the structure ("duct", "artery") that the running instruction names. A clip or
                a cut on another structure is an injury. None means the tube nearest to the jaws
                when they close.

        Raises:
            ValueError: the command is not (2, 7) finite numbers, or there is no patient; nothing
                has moved.
            ArithmeticError: the tissue did not stay finite.
        """
        self._require_patient()
        joints = np.asarray(command.joints, float)
        if joints.shape != (2, 7) or not np.isfinite(joints).all():
            raise ValueError(f"command: joints must be (2, 7) finite numbers, got {joints!r}")
        start, self._target = self._target, self.arms.limited(joints)
        way = self._target - start
        self._place_bars()
        moving = self.body.begin_step(self.config.control_step_s)
        self.arms.settle()
        for k, part in enumerate(self._shares, 1):
            for share in part:
                self.arms.drive(start + share * way)
                self.arms.apply_wrenches(*self.wrenches)
                if moving:
                    self.body.move_rigid(share)
                self.scene.step()
            if moving:
                self.body.move_tissue(part[-1])
            self._place_tools(T_world_link_before=self.tissue.T_world_links())
            self._step_tissue(time_s=self.record.time_s + k * self.config.tissue.step_s)
            self.wrenches = self.tissue.tool_wrenches()
        self.body.end_step()
        beyond_rad = float(np.abs(joints - self._target)[:, :6].max())
        self.record = record_step(self, self.config.control_step_s, beyond_rad, intended)
        return self.observe()

    def shift_body(self, offset_m: Array) -> None:
        """Move the body that holds the organ to an offset (3,) from its anatomical place, m.

        The body moves during the next control step, at a steady speed.
        """
        self._require_patient()
        self.body.target_m = np.array(offset_m, float)

    def observe(self) -> Observation:
        """Return the exact state, without images, as the sense `exact` observes it.

        A policy gets this observation only with the sense `exact`; the default sense `tracked` adds
        errors.
        """
        self._require_patient()
        return exact_observation(self)

    def images(self, names: Sequence[str]) -> dict[str, NDArray[np.uint8]]:
        """Draw the current field: camera name -> picture (height, width, 3).

        Raises:
            ValueError: the world was made without `render`, or there is no patient or no such
                camera.
        """
        if self.view is None:
            raise ValueError("world: it has no cameras: make it with render=True")
        self._require_patient()
        return self.view.images(self, names)

    def endoscope_rgb(self) -> NDArray[np.uint8]:
        """Draw the current picture (height, width, 3) of the endoscope's left eye."""
        return self.images(["endoscope_left"])["endoscope_left"]

    def equip(self, instrument: str) -> None:
        """Mount a tool on the right arm, or load a clip, as a scrub nurse does.

        Joints and targets beyond the new tool's limits are clipped to the limits.

        Raises:
            ValueError: the right arm has no such tool, or there is no patient.
        """
        self._require_patient()
        self.arms.mount(instrument)
        self._target = self.arms.limited(self._target)
        self.record = replace(
            self.record,
            clip_loaded=INSTRUMENTS[instrument].deed == "clip",
            jaws_opened=False,
        )
        self._place_tools()

    def drop_clip(self) -> None:
        """Drop the applier's clip. Do nothing if the applier has no clip."""
        self._require_patient()
        r = self.record
        if not r.clip_loaded:
            return
        T, kind = self.arms.T_world_tool()[RIGHT_ARM], clip_of(self.arms.mounted[RIGHT_ARM])
        clip = dropped_clip(T, kind, number=len(r.clips) + 1, time_s=r.time_s)
        self.record = replace(r, clips=(*r.clips, clip), clip_loaded=False)

    @property
    def target(self) -> Array:
        """Return the joints (2, 7) commanded last, within their limits."""
        self._require_patient()
        return self._target.copy()

    def pull_clip(self, number: int, force_world_n: Array, clamp: Indices) -> None:
        """Pull at a clip with a steady force (3,), N; zero ends the pull.

        A test machine clamps vertices meanwhile: they stand still, and take the reaction.

        Args:
            number: Number of the clip.
            force_world_n: (3,) force in the world frame, N.
            clamp: (n,) the clamped vertices.

        Raises:
            ValueError: there is no such clip, vertex or force, or no patient. Nothing is changed.
        """
        self._require_patient()
        force_world_n, clamp = np.array(force_world_n, float), np.asarray(clamp)
        _require_pull(force_world_n, clamp, self.tissue.n_vertex())
        clips = {clip.number: clip for clip in self.record.clips}
        if number not in clips:
            raise ValueError(f"world: there is no clip {number}; choose from {sorted(clips)}")
        clip = clips[number]
        load = self.tissue.host("load")[0]
        load[:] = 0.0
        pulls = not clip.lost and force_world_n.any()
        self._clamp(clamp if pulls else clamp[:0])
        if not pulls:
            self.record = replace(self.record, pull=None)
            return
        caught = list(clip.vertices)
        load[caught] = force_world_n / max(len(caught), 1)  # a clip may have caught no vertex
        before = self.record.pull
        if before is not None and before.number == number:
            grip = before.grip_n
        else:
            grip = grip_n(self.tubes, clip)
        pull = Pull(number=number, force_world_n=force_world_n, grip_n=grip)
        self.record = replace(self.record, pull=pull)

    def _clamp(self, vertices: Indices) -> None:
        clamped, before = self.tissue.host("clamped")[0], self.tissue.host("clamped")[0].copy()
        clamped[:] = 0
        clamped[vertices] = 1
        if (clamped != before).any():
            self.tissue.host("velocity")[0, vertices] = 0.0
            self.tissue.rewire(0)

    def state(self) -> dict[str, Any]:
        """Copy everything that the next step depends on, including the tissue's topology."""
        self._require_patient()
        return copied(self._parts(self.tissue, self.tubes)) | {"arms": self.arms.state()}

    def check(self, state: Any, anatomy: Anatomy | None = None) -> None:
        """Check that `restore` accepts a state. Nothing is changed.

        Args:
            state: a value that `state` returned.
            anatomy: the state's patient; by default the patient in this world.

        Raises:
            ValueError: `state` of such a world cannot have returned the value, or there is no
                patient in this world. The message says where the state is wrong, and why.
        """
        self._require_patient()
        anatomy = anatomy or self.anatomy
        known = anatomy == self.anatomy
        tissue, tubes = (self.tissue, self.tubes) if known else self._prepare(anatomy)
        example = self._parts(tissue, tubes) | {"anatomy": anatomy.hash}
        require_state(state, example, tissue, tubes, self.arms.joint_ranges)

    def restore(self, state: dict[str, Any]) -> None:
        """Restore the world to a value that `state` returned.

        Raises:
            ValueError: the state is of another anatomy or version, or damaged; nothing is changed.
        """
        self.check(state)
        state = copied(state)
        self.tissue.restore(state["tissue"])
        self.tubes.above, self.tubes.stations_m = state["above"], state["stations"]
        self.arms.restore(state["arms"])
        self._target = state["target"]
        self.T_world_endoscope = state["T_world_endoscope"]
        self.body.restore(state["body"])
        self.conditions = state["conditions"]
        self.wrenches = state["wrenches"]
        self.record = state["record"]
        self._place_tools()

    def _require_patient(self) -> None:
        """Check that `reset` has loaded a patient."""
        if "record" not in self.__dict__:
            raise ValueError("world: it has no patient yet: call reset(anatomy) first")

    def _step_tissue(self, time_s: float) -> None:
        """Advance the tissue by one step that ends at a time.

        One vertex that is not finite makes the solver's residual not finite. All other vertices
        then stay in place.

        Raises:
            ArithmeticError: a vertex is not finite.
        """
        self.tissue.step()
        finite = np.isfinite(self.tissue.positions())
        if not finite.all():
            first = int(finite.all(axis=1).argmin())
            raise ArithmeticError(f"tissue: vertex {first} is not finite at {time_s:.3f} s")

    def _parts(self, tissue: Tissue, tubes: Tubes) -> dict[str, Any]:
        """Return the content of a state, without copies."""
        return {
            "version": WORLD_VERSION,
            "anatomy": self.anatomy.hash,
            "tissue": tissue.parts(),
            "above": tubes.above,
            "stations": tubes.stations_m,
            "arms": self.arms.snapshot(),
            "target": self._target,
            "T_world_endoscope": self.T_world_endoscope,
            "body": self.body.state(),
            "conditions": self.conditions,
            "wrenches": self.wrenches,
            "record": self.record,
        }

    def _prepare(self, anatomy: Anatomy) -> tuple[Tissue, Tubes]:
        """Build a patient's tissue at rest."""
        organ = build_organ(anatomy)
        tissue = Tissue(
            [organ], stiffness_scale=[anatomy.stiffness_scale], config=self.config.tissue
        )
        return tissue, Tubes(tissue, organ)

    def _place_bars(self) -> None:
        """Let the tissue carry the clips in the current record."""
        if self._barred is not self.record.clips:
            self._barred = self.record.clips
            place_bars(self.tubes, self._barred)

    def _place_tools(self, **before: Array) -> None:
        shapes = self.arms.contact_shapes()
        self.tissue.place_tools(
            0,
            a=shapes.a_world_m,
            b=shapes.b_world_m,
            half_width=shapes.w_world_m,
            radius=shapes.radius_m,
            friction=self._friction(),
            T_world_link=shapes.T_world_link,
            **before,
        )

    def _friction(self) -> Array:
        """Return friction coefficients (8,): toothed grasper, smooth steel elsewhere (assumed)."""
        friction = np.full(8, 0.1)
        friction[2:4] = 0.7 * self.conditions.grip
        return friction


def _require_pull(force_world_n: Array, clamp: Indices, n_vertex: int) -> None:
    if force_world_n.shape != (3,) or not np.isfinite(force_world_n).all():
        raise ValueError(f"world: force_world_n = {force_world_n} must be 3 finite numbers, N")
    whole = clamp.dtype.kind in "iu"
    if len(clamp) and not (whole and 0 <= clamp.min() <= clamp.max() < n_vertex):
        raise ValueError(
            f"world: clamp = {clamp} must be vertices, whole numbers from 0 to {n_vertex - 1}"
        )
