"""Remember the clips: their number, their order of closing, their tubes and stations.

The applier's own closing counts a clip and places it, by the arm's encoders. Pictures then move
the clip's station little by little. The clip pins the tube where pictures show the clip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from controller.perception.evidence import find
from controller.perception.fusion import SAME_LOOKS, Lines
from controller.perception.graph import Shown
from tissue_sim.frames import Array
from tissue_sim.sensing.glance import Glance, Picture
from tissue_sim.sensing.observation import MAX_CLIPS, TUBE_POINTS
from tissue_sim.sensing.polyline import nearest_to_jaws, place_on
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.clips import ClipKind
from tissue_sim.tools.instruments import INSTRUMENTS

CAUGHT_M = 0.0035  # assumed: a tube observed this near to the closed jaws is in the clip
IN_JAWS_M = 0.0006  # assumed: how far the tube's middle lies from the jaws' mid-line
PLACED_M = 0.0005  # assumed standard deviation of a clip's station at closing
CREEP_M = 3e-4  # its growth, in a second's square root; chosen on tuning patients
EVIDENCE_PX = 2.0  # assumed standard deviation of a found clip


@dataclass(kw_only=True)
class SeatedClip:
    """One clip: on a tube at a station, or lying loose.

    Attributes:
        tube: The tube, 0 left, 1 right; None if the clip caught neither.
        at: Station of the clip, counted in the tube's points.
        variance_m2: Variance of the station.
        place_m: (3,) place where the clip closed.
    """

    tube: int | None
    at: float
    variance_m2: float
    place_m: Array


class Clips:
    """All clips so far."""

    def __init__(self) -> None:
        self._clips: list[SeatedClip] = []
        self._loaded = False

    def __len__(self) -> int:
        return len(self._clips)

    def step(self, glance: Glance, lines: Lines, passed_s: float) -> None:
        """Take in one control step: check whether the applier has closed on a structure."""
        kind = INSTRUMENTS[glance.tools[1]].clip
        if self._loaded and not glance.clip_loaded and kind is not None:
            self._close(glance.tips_endoscope[RIGHT_ARM], kind, lines)
        self._loaded = glance.clip_loaded
        for clip in self._clips:
            clip.variance_m2 += CREEP_M**2 * passed_s

    def look(
        self, pictures: dict[str, Picture], shown: dict[str, Shown], lines: Lines
    ) -> dict[int, bool]:
        """Take in the views' evidence; return which of the clips are visible."""
        seen = dict.fromkeys(range(len(self._clips)), False)
        places = [self._place(clip, lines) for clip in self._clips]
        for k, clip in enumerate(self._clips):
            others = places[:k] + places[k + 1 :]
            for name, picture in pictures.items():
                found = find("clip", shown[name], picture, places[k], others)
                if found is not None:
                    seen[k] = True
                    self._correct(clip, picture, found, lines)
        return seen

    def places(self, lines: Lines) -> tuple[Array, Array]:
        """Return places (`MAX_CLIPS`, 3) of the last clips, zeros beyond, and variances."""
        places_m, variance_m2 = np.zeros((MAX_CLIPS, 3)), np.zeros(MAX_CLIPS)
        for k, clip in enumerate(self._clips[-MAX_CLIPS:]):
            places_m[k] = self._place(clip, lines)
            nearby = 0.0 if clip.tube is None else lines.variance_m2[_point(clip)]
            variance_m2[k] = nearby + clip.variance_m2 / 3.0
        return places_m, variance_m2

    def _close(self, T_endoscope_tool: Array, kind: ClipKind, lines: Lines) -> None:
        tubes = [tube_m(lines, k) for k in (0, 1)]
        places = [nearest_to_jaws(tube, T_endoscope_tool, kind.length_m) for tube in tubes]
        tube = int(np.argmin([away for _, _, away in places]))
        k, share, away = places[tube]
        middle = T_endoscope_tool[:3, 3] - 0.5 * kind.length_m * T_endoscope_tool[:3, 2]
        if away > CAUGHT_M:
            clip = SeatedClip(tube=None, at=0.0, variance_m2=CAUGHT_M**2, place_m=middle)
        else:
            clip = SeatedClip(tube=tube, at=k + share, variance_m2=PLACED_M**2, place_m=middle)
            at, across = (TUBE_POINTS * tube + k, share), T_endoscope_tool[:3, :2].T
            lines.hold(T_endoscope_tool[:3, 3], at, across, IN_JAWS_M)
        self._clips.append(clip)

    def _place(self, clip: SeatedClip, lines: Lines) -> Array:
        return clip.place_m if clip.tube is None else _on(lines, clip.tube, clip.at)

    @staticmethod
    def _pin(clip: SeatedClip, picture: Picture, found: Array, lines: Lines) -> None:
        """Move the line to its clip in a picture; beside a cut the line has no shape."""
        k = int(np.clip(clip.at, 0, TUBE_POINTS - 2))
        if clip.tube is not None and lines.cuts.get(clip.tube, -1.0) // 1 != k:
            at = (TUBE_POINTS * clip.tube + k, clip.at - k)
            lines.pin(picture, found, at, clip.variance_m2)

    def _correct(self, clip: SeatedClip, picture: Picture, found: Array, lines: Lines) -> None:
        """Move a clip along its tube towards its place in a picture."""
        if clip.tube is None:
            return
        self._pin(clip, picture, found, lines)
        step = 0.01
        ends = np.stack([_on(lines, clip.tube, clip.at + s) for s in (0.0, step)])
        way_m = float(np.linalg.norm(ends[1] - ends[0])) / step
        (pixel, beside), _ = picture.project(ends)
        along = (beside - pixel) / (step * way_m)  # pixels a metre
        noise = (SAME_LOOKS * EVIDENCE_PX**2 + float(along @ along) * PLACED_M**2) / max(
            float(along @ along), 1.0
        )
        gain = clip.variance_m2 / (clip.variance_m2 + noise)
        moved_m = gain * float(along @ (found - pixel)) / max(float(along @ along), 1.0)
        clip.at = float(np.clip(clip.at + moved_m / max(way_m, 1e-6), 0.0, TUBE_POINTS - 1.0))
        clip.variance_m2 *= 1.0 - gain


def _on(lines: Lines, tube: int, at: float) -> Array:
    """Return the point (3,) at a station of a tube, on the stump to which the station belongs."""
    return place_on(tube_m(lines, tube), at, lines.cuts.get(tube))


def tube_m(lines: Lines, tube: int) -> Array:
    """Return the points (8, 3) of the left (0) or the right (1) tube."""
    return lines.points_m[TUBE_POINTS * tube : TUBE_POINTS * (tube + 1)]


def _point(clip: SeatedClip) -> int:
    """Return the number of the point of the lines that is nearest to a seated clip."""
    return TUBE_POINTS * (clip.tube or 0) + round(clip.at)
