"""Which observed points are hidden from all cameras? Rays test instruments and tissue.

A point lies inside its structure, so the structure's own wall may lie before the point. Peritoneum,
blood and smoke hide nothing here.
"""

from __future__ import annotations

from functools import cache

import numpy as np
import trimesh
from numpy.typing import NDArray

from tissue_sim.field import Field
from tissue_sim.frames import Array, inverse_pose, transform
from tissue_sim.mechanics.topology import boundary_faces
from tissue_sim.patient.at_risk import AT_RISK, RADIUS_M
from tissue_sim.sensing.cameras import CameraSpec, T_world_camera
from tissue_sim.sensing.observation import N_POINTS, ROWS, TUBE_POINTS, Observation
from tissue_sim.sensing.ray_tests import RayMesh, blocked
from tissue_sim.tools.clips import CLIPS
from tissue_sim.tools.instrument_meshes import link_parts
from tissue_sim.tools.instruments import INSTRUMENTS, PATCH_LINKS

EYES = ("endoscope_left", "wrist_left", "wrist_right")  # the right eye's view equals the left one's
DEPTH_M = 0.0015  # assumed: depth behind the first surface at which a wall is still visible
SAC_DEPTH_M = 0.02  # assumed: the sac's axis lies about this deep below its wall


class Occlusion:
    """Computes which points are hidden from all cameras of one field."""

    def __init__(self) -> None:
        self._tets: NDArray[np.int32] = np.zeros((0, 4), np.int32)
        self._tissue: RayMesh | None = None

    def __reduce__(self) -> tuple[type[Occlusion], tuple[()]]:
        """Copy without meshes, which are made again from the field."""
        return Occlusion, ()

    def hidden(self, field: Field, observation: Observation) -> NDArray[np.bool_]:
        """Return (`N_POINTS`,) which points of the exact observation no camera observes now.

        Points that it hides already, of a tube that is not there, stay hidden.
        """
        points = transform(field.T_world_endoscope, observation.points_m())
        T_world_eye = np.stack([T_world_camera(field, name) for name in EYES])
        visible = _in_view(T_world_eye, points) & ~self._blocked(
            field, observation, T_world_eye, points
        )
        return np.asarray(~visible.any(axis=0) | observation.hidden)

    def _blocked(
        self, field: Field, observation: Observation, T_world_eye: Array, points: Array
    ) -> NDArray[np.bool_]:
        """Return (eye, point) whether an object lies before the point."""
        links = [mesh for tool in field.arms.mounted for mesh in _meshes(tool.name)]
        return blocked(
            T_world_eye[:, :3, 3],
            points,
            depths_m(observation),
            self._tissue_mesh(field),
            links,
            inverse_pose(field.arms.T_world_links()),
        )

    def _tissue_mesh(self, field: Field) -> RayMesh:
        """Return the tissue's outer faces at their current places; cuts make new faces."""
        alive = field.tissue.host("tet_alive")[0, : len(field.organ.tets)] != 0
        tets, x = field.tissue.tets()[alive], field.tissue.positions()
        if self._tissue is None or not np.array_equal(tets, self._tets):
            self._tets = tets.copy()
            self._tissue = RayMesh(x, boundary_faces(tets)[0])
        else:
            self._tissue.move(x)
        return self._tissue


@cache
def _meshes(name: str) -> tuple[RayMesh, ...]:
    """Return a tool's links as meshes, each in its own frame, in the order of `PATCH_LINKS`."""
    parts = link_parts(INSTRUMENTS[name])
    return tuple(_joined([p.mesh for p in parts[k]]) for k in PATCH_LINKS)


def _joined(meshes: list[trimesh.Trimesh]) -> RayMesh:
    """Return several meshes as one."""
    counts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + n for mesh, n in zip(meshes, counts, strict=False)]
    return RayMesh(np.concatenate([mesh.vertices for mesh in meshes]), np.concatenate(faces))


def depths_m(observation: Observation) -> NDArray[np.float32]:
    """Return the depth (`N_POINTS`,) of each point below the wall of its structure."""
    deep = {"sac_m": SAC_DEPTH_M, "clips_m": max(kind.length_m for kind in CLIPS.values())}
    for name, trunk in zip(("common_bile_duct_m", "hepatic_artery_m"), AT_RISK, strict=True):
        deep[name] = RADIUS_M[trunk]
    depths = np.zeros(N_POINTS, np.float32)
    depths[ROWS["tubes_m"]] = np.repeat(observation.tube_radius_m, TUBE_POINTS)
    for name, depth_m in deep.items():
        depths[ROWS[name]] = depth_m
    return depths + np.float32(DEPTH_M)


def _in_view(T_world_eye: Array, points: Array) -> NDArray[np.bool_]:
    """Return (eye, point) whether a point lies within a camera's field of view."""
    spec = CameraSpec(name=EYES[0])
    up = np.tan(0.5 * spec.fov_rad)
    across = up * spec.width / spec.height
    at = np.stack([transform(inverse_pose(T), points) for T in T_world_eye])
    ahead = at[..., 0]
    inside = (np.abs(at[..., 1]) < across * ahead) & (np.abs(at[..., 2]) < up * ahead)
    return inside & (ahead > 0.0)
