"""Take pictures and read encoders and motor currents of a field, with assumed errors.

The views are the endoscope's left eye and a narrow crop of each wrist's camera. The left eye
alternates between its whole picture and a narrow crop at the tubes. The right eye adds nothing, and
the wrists' wide pictures added less than they cost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, exponential, inverse_pose, pose, transform
from tissue_sim.rendering.shader_pack import COLOR_PICTURE
from tissue_sim.rendering.view import FieldCameras
from tissue_sim.sensing.cameras import CROPS, CameraSpec, T_world_camera
from tissue_sim.sensing.glance import Glance, Picture
from tissue_sim.sensing.observation import Observation
from tissue_sim.sensing.sensor_model import SensorModel
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM

WHOLE, CLOSE = "endoscope_left", "endoscope_left_close"
VIEWS = (
    CameraSpec(name=WHOLE, width=160, height=120),
    CameraSpec(name=CLOSE, width=160, height=120, fov_rad=float(np.deg2rad(26.0))),
    CameraSpec(name="wrist_left_tip", width=128, height=128, fov_rad=float(np.deg2rad(23.0))),
    CameraSpec(name="wrist_right_tip", width=128, height=128, fov_rad=float(np.deg2rad(29.0))),
)
ENDOSCOPE_VIEWS = tuple(spec for spec in VIEWS if CROPS.get(spec.name, spec.name) == WHOLE)
LOOK_STEPS = 6  # control steps between two looks: ten looks per second have the same errors as five
JAW_PLAY_RAD = 0.004  # assumed: backlash between a jaw and its encoder
WHITE = 0.1  # assumed: share of a force's error that is new in each step; the rest is constant
USUAL = SensorModel()
Rgb = NDArray[np.uint8]
Spoil = Callable[[str, Rgb], Rgb]  # from a camera's name and picture to the spoiled picture


def as_it_is(camera: str, rgb: Rgb) -> Rgb:
    """Return a camera's picture (height, width, 3) unchanged."""
    del camera
    return rgb


class Eyes:
    """Observes one patient: call `glance` once in each control step.

    The errors of hand-eye registration, encoders and motor currents have the sizes of the sensor
    model, which are assumed.
    """

    def __init__(
        self,
        rng: np.random.Generator,
        model: SensorModel = USUAL,
        every: int = LOOK_STEPS,
        spoil: Spoil = as_it_is,
        views: Sequence[CameraSpec] = VIEWS,
    ) -> None:
        """Take `views` each `every` control steps; each picture passes through `spoil`."""
        self._model, self._rng, self._every, self._spoil = model, rng, every, spoil
        self._views = views
        self._force_n = model.force_n * rng.standard_normal(7)
        self._offset_m = model.hand_eye_m * rng.standard_normal((2, 3))
        turns = model.hand_eye_rad * rng.standard_normal((2, 3))
        self._turn = np.stack([exponential(turn) for turn in turns])
        self._jaw_rad: Array | None = None
        self._n, self._looks = 0, 0

    def glance(
        self, field: Field, view: FieldCameras, told: Observation, aim_m: Array | None = None
    ) -> Glance:
        """Return the current sensor values, with pictures in each `every`-th call.

        If there is a point of interest `aim_m` (3,), every other look replaces the endoscope's
        whole picture by its crop. The point is in the endoscope's frame. Of the exact state `told`,
        only the values from encoders and motor currents are used.
        """
        looks, self._n = self._n % self._every == 0, self._n + 1
        errors_n = self._force_n + WHITE * self._model.force_n * self._rng.standard_normal(7)
        tips = told.tips_endoscope
        return replace(
            Glance(**told.encoded),
            joints=self._encoders(told.joints),
            tips_endoscope=np.stack([self._believed(tips, a, tips[a]) for a in (0, 1)]),
            forces_n=told.forces_n + errors_n[:6].reshape(2, 3),
            pinch_n=max(told.pinch_n + float(errors_n[6]), 0.0),
            pictures=self._pictures(field, view, tips, aim_m) if looks else {},
        )

    def _pictures(
        self, field: Field, view: FieldCameras, tips: Array, aim_m: Array | None
    ) -> dict[str, Picture]:
        aims_m, left_out = {}, CLOSE
        if aim_m is not None and self._looks % 2 == 1:
            aims_m[CLOSE], left_out = transform(field.T_world_endoscope, aim_m), WHOLE
        self._looks += 1
        specs = [spec for spec in self._views if spec.name != left_out]
        rgb = view.pictures(field, specs, aims_m=aims_m)[COLOR_PICTURE]
        to_endoscope = inverse_pose(field.T_world_endoscope)
        made = {}
        for spec in specs:
            T = to_endoscope @ T_world_camera(field, spec.name, aims_m.get(spec.name))
            if CROPS.get(spec.name, WHOLE) != WHOLE:
                T = self._believed(tips, LEFT_ARM if "left" in spec.name else RIGHT_ARM, T)
            made[spec.name] = Picture(
                rgb=self._spoil(spec.name, rgb[spec.name]),
                T_endoscope_camera=T,
                focal_px=spec.focal_px,
            )
        return made

    def _believed(self, tips: Array, arm: int, T: Array) -> Array:
        """Return the pose (4, 4) on an arm by its encoders: turned about the tip, and shifted."""
        tip, turn = tips[arm, :3, 3], self._turn[arm]
        return pose(turn @ T[:3, :3], tip + turn @ (T[:3, 3] - tip) + self._offset_m[arm])

    def _encoders(self, joints: Array) -> Array:
        """Return the joints (2, 7) as read: a jaw follows its motor with some play."""
        if self._jaw_rad is None:
            self._jaw_rad = joints[:, 6].copy()
        play = 0.5 * JAW_PLAY_RAD
        self._jaw_rad = np.clip(self._jaw_rad, joints[:, 6] - play, joints[:, 6] + play)
        read = joints.copy()
        read[:, 6] = self._jaw_rad
        return read
