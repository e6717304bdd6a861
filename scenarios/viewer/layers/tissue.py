"""Layers of the tissue: organ, duct and artery, their connective tissue, and leaks."""

from __future__ import annotations

import numpy as np
import viser

from scenarios.viewer.frame import Frame, Patient
from scenarios.viewer.layers.layer import SEEN_M, Rgb, show, srgb
from tissue_sim.mechanics.topology import surface_faces
from tissue_sim.rendering.drawn_leaks import LEAK_LOOKS
from tissue_sim.rendering.drawn_strands import FIBRE_LOOK, SPREAD_M
from tissue_sim.rendering.drawn_tissue import looks
from tissue_sim.rendering.skin import build_skin
from tissue_sim.rendering.textures import DYE, Look

SPLITS = 2  # subdivisions: about 3,300 triangles, smooth enough on a screen


class TissueLayer:
    """The skin of the deforming gallbladder, duct and artery, and their cut faces.

    Triangles are sent only after a cut, otherwise only points.
    Most of the time the tissue hardly moves: then nothing is computed or sent.
    """

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._scene, self._root, self._patient = scene, f"{root}/tissue", patient
        self._rest_faces = surface_faces(patient.organ.tets)
        self._tets = np.zeros((0, 4), np.int32)
        self._meshes: dict[str, viser.MeshHandle] = {}
        self._dyed: float | None = None

    def update(self, frame: Frame) -> None:
        """Draw the tissue of this frame."""
        if not np.array_equal(frame.tets, self._tets):
            self._rebuild(frame)
        if (np.abs(frame.positions_m - self._shown_m) > SEEN_M).any():
            self._move(frame)
        if frame.dyed != self._dyed:
            self._colour(frame.dyed)

    def _move(self, frame: Frame) -> None:
        self._shown_m = frame.positions_m
        surfaces = self._skin.surfaces(frame.positions_m)
        for name, mesh in self._meshes.items():
            show(mesh, "vertices", surfaces[name][0])

    def _rebuild(self, frame: Frame) -> None:
        """Replace all meshes after a change of topology."""
        self._shown_m = np.full_like(frame.positions_m, np.inf)
        self._tets, self._dyed = frame.tets, None
        self._skin = build_skin(
            frame.tets,
            self._patient.organ.region[frame.alive],
            self._rest_faces[frame.alive],
            len(frame.positions_m),
            splits=SPLITS,
        )
        for mesh in self._meshes.values():
            mesh.remove()
        self._meshes = {
            name: self._scene.add_mesh_simple(
                f"{self._root}/{name}",
                np.zeros((patch.rows.stop - patch.rows.start, 3), np.float32),
                patch.triangles,
                side="double",
            )
            for name, patch in self._skin.patches.items()
        }

    def _colour(self, dyed: float) -> None:
        self._dyed = dyed
        for name, look in looks(self._patient.anatomy, dyed).items():
            if name in self._meshes:
                self._meshes[name].color = _rgb(look)


def _rgb(look: Look) -> Rgb:
    """Return the colour with the dye mixed in: deforming meshes have no texture here."""
    clean, dye = np.array(look.colour), np.array(DYE)
    red, green, blue = (1.0 - look.dyed) * clean + look.dyed * dye
    return srgb((red, green, blue))


class StrandLayer:
    """A thread for each intact strand of connective tissue."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._threads = scene.add_line_segments(
            f"{root}/strands",
            np.zeros((0, 2, 3)),
            srgb(FIBRE_LOOK.colour),
            thickness=SPREAD_M,
        )

    def update(self, frame: Frame) -> None:
        """Move the threads with the strands."""
        show(self._threads, "points", frame.strands_m)


class LeakLayer:
    """One mesh for each structure that leaks bile or blood."""

    def __init__(self, scene: viser.SceneApi, root: str, patient: Patient) -> None:
        self._scene, self._root = scene, f"{root}/leaks"
        self._meshes: dict[str, viser.MeshHandle] = {}

    def update(self, frame: Frame) -> None:
        """Draw the leaks of this frame."""
        for name in self._meshes.keys() - frame.leaks.keys():
            self._meshes.pop(name).remove()
        for name, surface in frame.leaks.items():
            points = np.asarray(surface.points, np.float32)
            known = self._meshes.get(name)
            if known is not None and known.vertices.shape == points.shape:
                known.vertices = points
            else:
                self._meshes[name] = self._scene.add_mesh_simple(
                    f"{self._root}/{name}",
                    points,
                    np.asarray(surface.triangles, np.uint32),
                    color=srgb(LEAK_LOOKS[name].colour),
                )
