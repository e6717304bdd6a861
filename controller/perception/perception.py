"""Compute the observation, the input of all policies, from a robot's cameras and encoders."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from controller.perception.checkpoint import CHECKPOINTS
from controller.perception.clips import Clips
from controller.perception.cuts import Cuts
from controller.perception.fusion import Lines, spread_px
from controller.perception.graph import Shown, ViewReader
from controller.perception.prior import Prior, share_of_motion
from controller.perception.radii import Radii
from controller.perception.third_tube import ThirdTube
from planner.learning.networks import kept
from tissue_sim.constants import CONTROL_PERIOD_S
from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES
from tissue_sim.sensing.glance import Glance, Picture
from tissue_sim.sensing.observation import (
    LIKELY,
    MAX_CLIPS,
    N_LINE,
    N_POINTS,
    ROWS,
    TUBE_POINTS,
    Observation,
    points_by_name,
)
from tissue_sim.sensing.rest_length import RestLengths

BIAS_M = 3e-4  # measured on tuning patients: the common error of all looks


class Perception:
    """Perceives one patient; `estimate` must be called once in each control step."""

    def __init__(self, viewer: ViewReader, prior: Prior) -> None:
        self._viewer = viewer
        self._lines, self._radii = Lines(prior), Radii(prior)
        self._clips, self._cuts, self._lengths = Clips(), Cuts(), RestLengths()
        self._tips_m: Array | None = None
        self._age_s, self._hidden = np.zeros(N_POINTS), np.ones(N_POINTS, bool)
        self._sight: dict[str, NDArray[np.bool_]] = {}  # of each view's last look
        self._third = ThirdTube()

    @property
    def aim_m(self) -> Array:
        """Return the point (3,) at which the endoscope's crop should look: the tubes' middle."""
        return self._lines.points_m[: len(USUAL_TUBES) * TUBE_POINTS].mean(axis=0)

    def estimate(self, glance: Glance) -> Observation:
        """Return the present observation."""
        tips_m = glance.tips_endoscope[:, :3, 3]
        self._lines.wait(CONTROL_PERIOD_S, share_of_motion(tips_m, self._tips_m, glance.pinch_n))
        self._tips_m = tips_m.copy()
        self._clips.step(glance, self._lines, CONTROL_PERIOD_S)
        self._cuts.step(glance, self._lines)
        self._lines.cuts = self._cuts.stations()
        self._age_s += CONTROL_PERIOD_S
        if glance.pictures:
            self._look(glance.pictures)
        return self._observation(glance)

    def _look(self, pictures: dict[str, Picture]) -> None:
        shown = {name: self._viewer(name, picture.rgb) for name, picture in pictures.items()}
        self._lines.look(pictures, shown)
        self._radii.look(pictures, shown, self._lines.points_m)
        self._cuts.look(pictures, shown, self._lines)
        self._sight |= _in_sight(pictures, shown, self._lines.points_m)
        self._hidden[:N_LINE] = ~np.any(list(self._sight.values()), axis=0)
        self._hidden[N_LINE:] = True
        oldest = max(len(self._clips) - MAX_CLIPS, 0)
        for k, seen in self._clips.look(pictures, shown, self._lines).items():
            if k >= oldest:
                self._hidden[N_LINE + k - oldest] = not seen
        self._age_s[~self._hidden] = 0.0
        self._third.look(shown)
        self._lines.n_tubes = len(TUBES if self._third.chance > LIKELY else USUAL_TUBES)

    def _observation(self, glance: Glance) -> Observation:
        clips_m, clips_m2 = self._clips.places(self._lines)
        n_clips, n_tubes, there = len(self._clips), self._lines.n_tubes, self._there()
        points = there[:, None] * np.concatenate([self._lines.points_m, clips_m])
        std_m = np.sqrt(np.concatenate([self._lines.variance_m2, clips_m2]) + BIAS_M**2) * there
        exist = np.arange(len(TUBES)) < n_tubes
        rest_length_m = self._lengths.estimate(
            points, std_m, pinch_n=glance.pinch_n, n_clips=n_clips
        )
        return Observation(
            **glance.encoded,
            **points_by_name(points),
            n_clips=n_clips,
            severed=self._cuts.severed & exist,
            tube_radius_m=self._radii.tubes_m * exist,
            rest_length_m=rest_length_m * exist,
            rest_length_std_m=self._lengths.std_m * exist,
            third_tube=self._third.chance,
            sac_radius_m=self._radii.sac_m,
            std_m=std_m,
            age_s=self._age_s * there,
            hidden=np.where(there, self._hidden, np.arange(N_POINTS) < N_LINE),
            images={name: picture.rgb for name, picture in glance.pictures.items()},
        )

    def _there(self) -> NDArray[np.bool_]:
        """Return which points (`N_POINTS`,) stand for something that is there."""
        there = np.arange(N_POINTS) < N_LINE + len(self._clips)
        there[self._lines.n_tubes * TUBE_POINTS : ROWS["tubes_m"].stop] = False
        return there


def _in_sight(
    pictures: dict[str, Picture], shown: dict[str, Shown], points: Array
) -> dict[str, NDArray[np.bool_]]:
    """Return which points (`N_LINE`,) each view shows."""
    sight = {}
    for name, picture in pictures.items():
        _, ahead = picture.project(points)
        known = np.isfinite(spread_px(picture, shown[name], ahead))
        sight[name] = known & (shown[name].visible > 0.0)
    return sight


def load_perception(checkpoint: str | Path | None = None) -> Perception:
    """Return the perception of a checkpoint, by default the one that comes with Calot, if any.

    Raises:
        CheckpointError: There is no checkpoint, or the checkpoint does not fit.
    """
    return Perception(*_loaded(CHECKPOINTS.chosen(checkpoint)))


@kept
def _loaded(path: Path) -> tuple[ViewReader, Prior]:
    model = CHECKPOINTS.load(path)
    return ViewReader(model), model.prior()
