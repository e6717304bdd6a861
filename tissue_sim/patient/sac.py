"""Model the gallbladder's wall, patch by patch: torn or cut patches, and the area of holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.mechanics.layout import sac_skin
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.mechanics.topology import distances_to_triangles, encloses
from tissue_sim.patient.mesher import Indices
from tissue_sim.patient.organ import Organ
from tissue_sim.patient.tubes import MEETING_HALF_GAP_M
from tissue_sim.patient.walls import SAC, n_patches, patch_corners, wall_pieces

ENTRY_SAMPLES = 41  # places along a tool that are tested for its entry into the wall
BLADE_SAMPLES = 9  # sample points on the blades' trace across a patch


class Sac:
    """The gallbladder of one environment, without own state: the tissue stores living elements."""

    def __init__(self, tissue: Tissue, organ: Organ, b: int = 0) -> None:
        self.tissue, self.b = tissue, b
        self._corners = patch_corners(organ)
        row, piece = wall_pieces(organ).T
        self._patch = np.where(row == SAC, piece, -1)
        self._one_tet = np.unique(self._patch, return_index=True)[1][-n_patches(organ) :]
        volume = tissue.host("volume")[b, : len(organ.tets)]
        self._skin = sac_skin(organ)
        self._outer = np.unique(self._skin)
        self.contents_m3 = float(volume[organ.region == 1].sum())

    def stretch(self) -> float:
        """Return the stretch of the most stretched patch, from `Tissue.load_walls`."""
        return float(self.tissue.host("patch_stretch")[self.b].max())

    def open_patches(self) -> Indices:
        """Return the open patches."""
        alive = self.tissue.host("tet_alive")[self.b, self._one_tet]
        return np.flatnonzero(alive == 0).astype(np.int32)

    def hole_m2(self) -> float:
        """Return the current area of the holes: the area of the open patches' inner sides."""
        inner = self.tissue.positions(self.b)[self._corners[self.open_patches(), 0]]
        return float(_areas(inner.astype(float)).sum())

    def hole_centre(self) -> Array:
        """Return the centre (3,) of the first open patch, world frame."""
        first = self._corners[self.open_patches()[0]]
        return self.tissue.positions(self.b)[first].reshape(-1, 3).mean(axis=0).astype(float)

    def depth_m(self, points_m: Array) -> float:
        """Return how deep the deepest of points (n, 3) lies below the outer surface; 0 outside.

        World frame. The surface is the whole surface: holes do not count as outside.
        """
        x = self.tissue.positions(self.b)
        outer = np.ascontiguousarray(x.take(self._outer, axis=0).T)  # row per axis: fast to reduce
        near = ((points_m > outer.min(axis=1)) & (points_m < outer.max(axis=1))).all(axis=1)
        if not near.any():
            return 0.0
        skin, points_m = x[self._skin].astype(float), points_m[near]
        inside = points_m[encloses(skin, points_m)]
        return max((float(distances_to_triangles(skin, p).min()) for p in inside), default=0.0)

    def pierced(self, tips_m: Array, hilts_m: Array) -> Indices:
        """Return the whole patches through which tools have entered, world frame.

        Args:
            tips_m: (n, 3) tips, inside of the gallbladder.
            hilts_m: (n, 3) other ends of their axes, outside or inside.
        """
        x = self.tissue.positions(self.b)
        share = np.linspace(0.0, 1.0, ENTRY_SAMPLES)[:, None]
        middles = x[self._corners[:, 1]].astype(float).mean(axis=1)
        skin, found = x[self._skin].astype(float), []
        for tip, hilt in zip(tips_m, hilts_m, strict=True):
            way = tip + share * (hilt - tip)
            entry = way[np.argmin(encloses(skin, way))]  # the first place outside; the tip if none
            found.append(int(np.argmin(np.linalg.norm(middles - entry, axis=1))))
        return np.setdiff1d(found, self.open_patches()).astype(np.int32)

    def tear(self) -> None:
        """Open the most stretched patch; the other patches may then hold."""
        self.open(np.array([np.argmax(self.tissue.host("patch_stretch")[self.b])]))

    def open(self, patches: NDArray[np.integer]) -> None:
        """Remove the patches' elements and rewire the tissue."""
        tissue, b = self.tissue, self.b
        tissue.host("tet_alive")[b, : len(self._patch)][np.isin(self._patch, patches)] = 0
        tissue.rewire(b)

    def under_blades(self, T_world_tool: Array, reach_m: float) -> Indices:
        """Return the whole patches whose outer side lies where the closing blades meet.

        Args:
            T_world_tool: (4, 4) pose of the tool; its jaws meet in the plane x = 0.
            reach_m: Length, back from the tip, over which the blades cut.
        """
        outer = self.tissue.positions(self.b)[self._corners[:, 1]].astype(float)
        start, end, crossed = _trace(transform(inverse_pose(T_world_tool), outer))
        share = np.linspace(0.0, 1.0, BLADE_SAMPLES)[:, None, None]
        _, y, z = np.moveaxis(start + share * (end - start), -1, 0)
        met = (np.abs(y) < MEETING_HALF_GAP_M) & (-reach_m < z) & (z < 0.0)
        met = np.flatnonzero(crossed & met.any(axis=0)).astype(np.int32)
        return np.setdiff1d(met, self.open_patches())


def _trace(quads: Array) -> tuple[Array, Array, Array]:
    """Find the lines in which quadrilaterals (n, 4, 3) cross the plane x = 0.

    Returns:
        start and end (n, 3) of each line, and whether each quadrilateral crosses (n,).
    """
    ahead = np.roll(quads, -1, axis=1)
    x, x_ahead = quads[..., 0], ahead[..., 0]
    through = (x <= 0.0) != (x_ahead <= 0.0)  # of the four sides, two, four or none
    share = np.where(through, x / np.where(through, x - x_ahead, 1.0), 0.0)
    points = quads + share[..., None] * (ahead - quads)
    each = np.arange(len(quads))
    first, last = np.argmax(through, axis=1), 3 - np.argmax(through[:, ::-1], axis=1)
    return points[each, first], points[each, last], through.any(axis=1)


def _areas(quads: Array) -> Array:
    """Return the (n,) areas of quadrilaterals (n, 4, 3): half the diagonals' cross product."""
    diagonals = quads[:, 2:] - quads[:, :2]
    return 0.5 * np.linalg.norm(np.cross(diagonals[:, 0], diagonals[:, 1]), axis=1)
