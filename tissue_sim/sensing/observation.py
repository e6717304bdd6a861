"""Define what every acting part observes in each control step: tools, tissue, clips, forces.

Planner, controller, safety filter and nurse get one `Observation` and nothing else. An observation
comes from one of four senses (`sense.py`), and states the uncertainty of each point.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from dataclasses import fields as dataclass_fields
from itertools import accumulate, pairwise, starmap, takewhile
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.patient.tube_names import TUBES, USUAL_TUBES, Tube
from tissue_sim.read_only import seal
from tissue_sim.sensing.polyline import nearest_on
from tissue_sim.tools.instruments import GRASPER, INSTRUMENTS, Instrument, right_tools

TUBE_POINTS = 8  # along each tube, from the fixed end up
SAC_POINTS = 5  # along the infundibulum, from the neck up
TRUNK_POINTS = 4  # along each structure at risk
MAX_CLIPS = 12  # nine of a patient with a third tube, and some that were repeated
LIKELY = 0.5  # a third tube is there from this probability on
POINTS = {
    "tubes_m": len(TUBES) * TUBE_POINTS,
    "sac_m": SAC_POINTS,
    "common_bile_duct_m": TRUNK_POINTS,
    "hepatic_artery_m": TRUNK_POINTS,
    "clips_m": MAX_CLIPS,
}
"""Order and numbers of the points that `std_m`, `age_s` and `hidden` count."""

_FIRSTS = pairwise(accumulate(POINTS.values(), initial=0))
ROWS = dict(zip(POINTS, starmap(slice, _FIRSTS), strict=True))
"""The rows of each field of `POINTS` among all points."""

TUBE_ROWS = {tube: slice(k * TUBE_POINTS, (k + 1) * TUBE_POINTS) for k, tube in enumerate(TUBES)}
"""The rows of each tube among all points; the tubes come first."""

_OTHERS = {name: ROWS[name] for name in POINTS if name not in ("tubes_m", "clips_m")}
LINE_ROWS: dict[str, slice] = {**TUBE_ROWS, **_OTHERS}
"""The rows of each line: of each tube by its name, and of the other lines by their fields."""

N_POINTS = sum(POINTS.values())
N_LINE = N_POINTS - MAX_CLIPS  # points that belong to lines; the other points are clips
N_SHOWN = N_POINTS + 2 * len(TUBES)  # points in pictures: with both ends of each tube's cut


@dataclass(frozen=True, kw_only=True)
class Encoded:
    """What encoders and motor currents tell of one control step, without a camera.

    Rows: left, right arm. Frame: endoscope (+x left, +y up, +z away).

    Attributes:
        time_s: Time since the episode's start.
        joints: (2, 7) current joints: yaw, pitch, insertion (m), roll, wrist pitch, wrist yaw, jaw
            (rad).
        tips_endoscope: (2, 4, 4) `T_endoscope_tool`.
        forces_n: (2, 3) force of the tissue on each tool.
        pinch_n: Force of the grasper's jaws on the tissue between them.
        tools: Names of the mounted instruments.
        clip_loaded: Whether the applier holds a clip.
        clip_kinds: Names of the kinds of all clips that the applier closed or dropped, in order.
        T_world_endoscope: (4, 4) the endoscope's pose, from its holder's encoders.
        shaft_offset_m: (2,) distance of each shaft from its remote centre, by the arm's sensors.
    """

    time_s: float
    joints: Array
    tips_endoscope: Array
    forces_n: Array
    pinch_n: float
    tools: tuple[str, str]
    clip_loaded: bool
    clip_kinds: tuple[str, ...] = ()
    T_world_endoscope: Array = field(default_factory=lambda: np.eye(4))
    shaft_offset_m: Array = field(default_factory=lambda: np.zeros(2))

    @property
    def encoded(self) -> dict[str, Any]:
        """Return these fields by name."""
        return {part.name: getattr(self, part.name) for part in dataclass_fields(Encoded)}


@dataclass(frozen=True, kw_only=True)
class Observation(Encoded):
    """One control step; rows and frame as in `Encoded`.

    All readers share the same observation, so its arrays are read-only; write into a copy.

    Attributes:
        tubes_m: (3, 8, 3) points of the tubes' centrelines, in the order of `TUBES`. Left and
            right are as the endoscope sees them. Without a third tube, all its values are zero,
            and its points hidden. The accessors take the tube's name.
        sac_m: (5, 3) axis of the infundibulum.
        common_bile_duct_m, hepatic_artery_m: (4, 3) points of the centrelines of the structures at
            risk.
        clips_m: (`MAX_CLIPS`, 3) clips in order of closing, zeros beyond `n_clips`.
        n_clips: Number of clips closed so far; the last `MAX_CLIPS` have places.
        severed: (3,) whether each tube is cut or torn through.
        tube_radius_m: (3,) outer radii of the tubes.
        rest_length_m: (3,) lengths of the tubes before any traction.
        rest_length_std_m: (3,) standard deviations of these lengths.
        third_tube: Probability that a third tube runs to the gallbladder, 0 to 1.
        std_m: (`N_POINTS`,) standard deviation of each point's place along any axis. Across its
            line a point may be more certain.
        age_s: (`N_POINTS`,) time since a camera last observed the point.
        hidden: (`N_POINTS`,) whether no camera observes the point now.
        sac_radius_m: (5,) outer radii of the infundibulum at `sac_m`.
        stands_still: Whether the safety filter has stopped an arm for so long that a person should
            check.
        images: Camera name -> (height, width, 3) uint8, if images were drawn.
    """

    tubes_m: Array
    sac_m: Array
    common_bile_duct_m: Array
    hepatic_artery_m: Array
    clips_m: Array
    n_clips: int
    severed: NDArray[np.bool_]
    tube_radius_m: Array
    rest_length_m: Array
    rest_length_std_m: Array = field(default_factory=lambda: np.zeros(len(TUBES)))
    third_tube: float = 0.0
    sac_radius_m: Array = field(default_factory=lambda: np.zeros(SAC_POINTS))
    std_m: Array = field(default_factory=lambda: np.zeros(N_POINTS))
    age_s: Array = field(default_factory=lambda: np.zeros(N_POINTS))
    hidden: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(N_POINTS, bool))
    stands_still: bool = False
    images: dict[str, NDArray[np.uint8]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        seal(self)

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Restore a copied or pickled state, whose arrays numpy makes writable, as read-only."""
        vars(self).update(state)
        seal(self)

    @property
    def right_instrument(self) -> Instrument:
        """Return the instrument that the right arm holds."""
        return INSTRUMENTS[self.tools[1]]

    @property
    def right_tool(self) -> Array:
        """Return one number for each of `right_tools`: 1 for the mounted tool, else 0."""
        return np.array([name == self.tools[1] for name in right_tools()], float)

    @property
    def tubes(self) -> tuple[Tube, ...]:
        """Return the names of the tubes that are there."""
        return TUBES if self.third_tube > LIKELY else USUAL_TUBES

    @property
    def there(self) -> NDArray[np.bool_]:
        """Return which points (`N_POINTS`,) stand for something that is there."""
        there = np.arange(N_POINTS) < N_LINE + self.n_clips
        for tube in TUBES:
            there[TUBE_ROWS[tube]] = tube in self.tubes
        return there

    @property
    def all_severed(self) -> bool:
        """Return whether all tubes that are there are severed."""
        return all(map(self.is_severed, self.tubes))

    def tube_m(self, tube: Tube) -> Array:
        """Return the points (`TUBE_POINTS`, 3) of a tube's centreline."""
        return self.tubes_m[TUBES.index(tube)]

    def radius_m(self, tube: Tube) -> float:
        """Return a tube's outer radius."""
        return float(self.tube_radius_m[TUBES.index(tube)])

    def length_m(self, tube: Tube) -> float:
        """Return a tube's length before any traction."""
        return float(self.rest_length_m[TUBES.index(tube)])

    def length_std_m(self, tube: Tube) -> float:
        """Return the standard deviation of a tube's length."""
        return float(self.rest_length_std_m[TUBES.index(tube)])

    def is_severed(self, tube: Tube) -> bool:
        """Return whether a tube is cut or torn through."""
        return bool(self.severed[TUBES.index(tube)])

    def points_m(self) -> Array:
        """Return all points (`N_POINTS`, 3), in the order of `POINTS`."""
        return np.concatenate([getattr(self, name).reshape(-1, 3) for name in POINTS])

    def vector(self) -> NDArray[np.float32]:
        """Flatten the parts that `VECTOR_LAYOUT` names into (`VECTOR_SIZE`,)."""
        poses = {"tips_endoscope": self.tips_endoscope[:, :3]}
        parts = (poses[name] if name in poses else getattr(self, name) for name in VECTOR_LAYOUT)
        return np.concatenate(list(parts), axis=None, dtype=np.float32)


def points_by_name(points: Array) -> dict[str, Any]:
    """Split points (`N_POINTS`, 3) by the names of `POINTS`."""
    return {name: points[rows].reshape(VECTOR_LAYOUT[name]) for name, rows in ROWS.items()}


def tip_to_tubes_m(observation: Observation) -> float:
    """Return the distance of the right tip to the nearest tube's centreline, m."""
    tip_m = observation.tips_endoscope[1, :3, 3]
    return min(nearest_on(observation.tube_m(tube), tip_m)[2] for tube in observation.tubes)


VECTOR_LAYOUT: dict[str, tuple[int, ...]] = {
    "joints": (2, 7),
    "tips_endoscope": (2, 3, 4),
    "forces_n": (2, 3),
    "pinch_n": (1,),
    **{name: (n, 3) for name, n in POINTS.items()} | {"tubes_m": (len(TUBES), TUBE_POINTS, 3)},
    "n_clips": (1,),
    "clip_loaded": (1,),
    "right_tool": (len(right_tools()),),
    "severed": (len(TUBES),),
    "tube_radius_m": (len(TUBES),),
    "sac_radius_m": (SAC_POINTS,),
    "rest_length_m": (len(TUBES),),
    "rest_length_std_m": (len(TUBES),),
    "third_tube": (1,),
    "std_m": (N_POINTS,),
    "age_s": (N_POINTS,),
    "hidden": (N_POINTS,),
}
"""Order and shapes of the parts of `Observation.vector()`."""

_ENDS = list(accumulate(prod(shape) for shape in VECTOR_LAYOUT.values()))
_PARTS = dict(zip(VECTOR_LAYOUT, starmap(slice, pairwise([0, *_ENDS])), strict=True))
VECTOR_SIZE = _ENDS[-1]
_BEFORE_POINTS = takewhile(lambda name: name not in POINTS, VECTOR_LAYOUT)
POINTS_BEGIN = sum(prod(VECTOR_LAYOUT[name]) for name in _BEFORE_POINTS)
POINTS_END = POINTS_BEGIN + 3 * N_POINTS
"""Range of the points of `POINTS`, one after the other, in `Observation.vector()`."""

ENCODED = ("joints", "tips_endoscope", "forces_n", "pinch_n", "clip_loaded", "right_tool")
"""The parts of `Observation.vector()` that come from encoders and motor currents, without a
camera."""


def fields(vectors: Any) -> dict[str, Any]:
    """Split vectors (..., `VECTOR_SIZE`), arrays or tensors, into views (..., *shape) by name."""
    return {name: part_of(vectors, name) for name in VECTOR_LAYOUT}


def part_of(vectors: Any, name: str) -> Any:
    """Return one part of vectors, as `fields` does."""
    return vectors[..., _PARTS[name]].reshape(*vectors.shape[:-1], *VECTOR_LAYOUT[name])


def encoded_and_tissue(vectors: NDArray[np.float32]) -> tuple[NDArray, NDArray]:
    """Return the parts that `ENCODED` names, and all others, of vectors (n, `VECTOR_SIZE`)."""
    parts = fields(vectors)
    flat = {name: part.reshape(len(vectors), -1) for name, part in parts.items()}
    encoded = np.concatenate([flat[name] for name in ENCODED], axis=1)
    return encoded, np.concatenate([flat[n] for n in flat if n not in ENCODED], axis=1)


def observation_of(vector: NDArray[np.float32], time_s: float, **others: Any) -> Observation:
    """Return the observation of an `Observation.vector()`.

    The fields that are no part of the vector are `others`, or have their defaults.
    """
    parts = fields(vector.astype(float))
    tips = np.zeros((2, 4, 4))
    tips[:, :3], tips[:, 3, 3] = parts["tips_endoscope"], 1.0
    others |= {
        "time_s": time_s,
        "tips_endoscope": tips,
        "pinch_n": float(parts["pinch_n"][0]),
        "tools": (GRASPER, right_tools()[int(parts.pop("right_tool").argmax())]),
        "clip_loaded": bool(parts["clip_loaded"][0] > 0.5),
        "n_clips": round(float(parts["n_clips"][0])),
        "severed": parts["severed"] > 0.5,
        "third_tube": float(parts["third_tube"][0]),
        "hidden": parts["hidden"] > 0.5,
    }
    return Observation(**parts | others)
