"""Make Calot's own meshes of shaft, wrist and fingers, in their link frames, for rendering.

Every mesh is coloured and swept: a closed section moved along a path, with flat ends. Fingers are
modelled in tool axes (x pivot, y closing, z forward). The model is the finger on the +y side; half
a turn about z gives the other finger. The inner faces lie in the plane y = 0, where the fingers
meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from tissue_sim.frames import Array, unit
from tissue_sim.tools.instruments import (
    CLIP_APPLIER,
    GRASPER,
    SCISSORS,
    SHAFT_LENGTH_M,
    SHAFT_RADIUS_M,
    SLIM_CLIP_APPLIER,
    Instrument,
)
from tissue_sim.tools.psm import T_YAW_TOOL_AXES

MM = 1e-3
_CREASE_RAD = np.deg2rad(35.0)  # edges sharper than this are shaded as edges
_X, _Y, _Z = np.eye(3)


@dataclass(frozen=True, kw_only=True)
class Finish:
    """Surface appearance: linear base colour and the metallic-roughness model of glTF."""

    rgb: tuple[float, float, float]
    metallic: float
    roughness: float


COMPOSITE = Finish(rgb=(0.035, 0.037, 0.042), metallic=0.0, roughness=0.45)
STEEL = Finish(rgb=(0.62, 0.63, 0.66), metallic=0.55, roughness=0.32)
DARK_STEEL = Finish(rgb=(0.20, 0.20, 0.22), metallic=0.5, roughness=0.4)


@dataclass(frozen=True, kw_only=True)
class Part:
    """A closed surface in its link's frame (m) and its finish."""

    mesh: trimesh.Trimesh
    finish: Finish


def link_parts(instrument: Instrument) -> dict[str, list[Part]]:
    """Return the parts of each visible link of `urdf.py`."""
    finger = _FINGERS.get(instrument.name, _plain_finger)(instrument)
    return {
        "shaft": _shaft(),
        "wrist": _wrist(instrument.pitch_to_yaw_m),
        "palm": _palm(),
        "finger_plus": finger,
        "finger_minus": _transform_parts(finger, np.diag([-1.0, -1.0, 1.0, 1.0])),
    }


def link_meshes(instrument: Instrument) -> dict[str, bytes]:
    """Return the content of a GLB file for each link."""
    return {link: _glb(parts) for link, parts in link_parts(instrument).items()}


def _glb(parts: Iterable[Part]) -> bytes:
    scene = trimesh.Scene([with_finish(part) for part in parts])
    exported = scene.export(file_type="glb", include_normals=True)
    assert isinstance(exported, bytes), "a GLB file is binary"
    return exported


def with_finish(part: Part) -> trimesh.Trimesh:
    """Return the part's mesh with its finish as a material, shaded smooth except at its edges."""
    shaded = trimesh.graph.smooth_shade(part.mesh, angle=_CREASE_RAD)
    shaded.visual = TextureVisuals(
        material=PBRMaterial(
            baseColorFactor=[*part.finish.rgb, 1.0],
            metallicFactor=part.finish.metallic,
            roughnessFactor=part.finish.roughness,
        )
    )
    return shaded


def _shaft() -> list[Part]:
    r, back = SHAFT_RADIUS_M, -SHAFT_LENGTH_M
    tube = _revolve([(back, r), (-12 * MM, r)])
    collar = _revolve([(-12 * MM, r), (-7.5 * MM, r), (-6.5 * MM, 0.85 * r)])
    cheeks = [_cheek(_Z, _Y, side * 2.9 * MM, -7 * MM, 0.0) for side in (-1, 1)]
    return [Part(mesh=tube, finish=COMPOSITE), *_steel(collar, *cheeks), _pin(_Y, 3.85 * MM)]


def _wrist(pitch_to_yaw_m: float) -> list[Part]:
    """Return the clevis: x forward, a tongue about pitch axis z, two cheeks about yaw axis y."""
    tongue = _cheek(_X, _Z, 0.0, 0.55 * pitch_to_yaw_m, 0.0, half_thickness=2.2 * MM)
    cheeks = [
        _cheek(_X, _Y, side * 2.7 * MM, 0.35 * pitch_to_yaw_m, pitch_to_yaw_m) for side in (-1, 1)
    ]
    pin = _pin(_Y, 3.65 * MM)
    pin.mesh.apply_translation(pitch_to_yaw_m * _X)
    return [*_steel(tongue, *cheeks), pin]


def _palm() -> list[Part]:
    hub = _prism(_disc(2.0 * MM), _X, -2.1 * MM, 2.1 * MM)
    hub.apply_transform(T_YAW_TOOL_AXES)
    return [Part(mesh=hub, finish=DARK_STEEL)]


def _grasper_finger(instrument: Instrument) -> list[Part]:
    """Return a fenestrated loop with two rows of teeth."""
    half, start, tip = _pad(instrument)
    rail, gap = 0.75 * MM, 0.25 * MM  # half width of the loop's bar; depth of the teeth
    mid = instrument.finger_half_width_m + 0.6 * half - rail
    arc = np.linspace(np.pi, 0.0, 13)
    bow = [(mid * np.cos(a), tip - mid + (mid - rail) * np.sin(a)) for a in arc]
    path = np.array(
        [(x, 0.5 * (2 * half + gap), z) for x, z in [(-mid, start), *bow, (mid, start)]]
    )
    loop = _sweep(path, _rounded(rail, half - gap / 2, 0.3 * MM), binormal=_Y)
    pitch = 0.9 * MM
    rows = np.arange(start + pitch, tip - mid, pitch)
    teeth = [_tooth(side * mid, z, rail, pitch, gap) for side in (-1, 1) for z in rows]
    return _steel(loop, *teeth, *_shank(instrument, half_width_m=mid + rail))


def _clip_applier_finger(instrument: Instrument) -> list[Part]:
    """Return a slim channel: a back, two rails with the clip's groove between, a tip hook."""
    half, start, tip = _pad(instrument)
    width = instrument.finger_half_width_m + 0.8 * half
    rail = 0.32 * width
    back = _bar(0.0, 1.35 * half, start, tip, width, 0.65 * half)
    rails = [
        _bar(side * (width - rail), 0.75 * half, start, tip, rail, 0.75 * half) for side in (-1, 1)
    ]
    hook = _bar(0.0, 0.8 * half, tip - 1.6 * MM, tip + 0.3 * half, width, 0.8 * half)
    heel = _bar(0.0, 0.8 * half, start, start + 1.2 * MM, width, 0.8 * half)
    return _steel(back, *rails, hook, heel, *_shank(instrument, half_width_m=width))


def _scissor_finger(instrument: Instrument) -> list[Part]:
    """Return a tapered blade that bows sideways; its cutting edge runs along the plane x = 0."""
    half, start, tip = _pad(instrument)
    s = np.linspace(0.0, 1.0, 14)
    taper = 1.0 - 0.65 * s**1.5
    thick = instrument.finger_half_width_m + half
    bow = 0.9 * MM * np.sin(np.pi * s)
    outline = np.array([(0.0, -0.15), (0.15, -0.15), (0.9, 0.8), (0.8, 1.7), (0.35, 2.1), (0, 2.0)])
    rings = np.stack(
        [
            np.column_stack(
                [b + outline[:, 0] * thick * k, outline[:, 1] * half * k, np.full(6, z)]
            )
            for b, k, z in zip(bow, taper, start + s * (tip - start), strict=True)
        ]
    )
    return _steel(_loft(rings), *_shank(instrument, half_width_m=thick))


def _plain_finger(instrument: Instrument) -> list[Part]:
    """Return a smooth bar."""
    half, start, tip = _pad(instrument)
    width = instrument.finger_half_width_m + half
    return _steel(_bar(0.0, half, start, tip, width, half), *_shank(instrument, half_width_m=width))


_FINGERS = {
    GRASPER: _grasper_finger,
    CLIP_APPLIER: _clip_applier_finger,
    SLIM_CLIP_APPLIER: _clip_applier_finger,
    SCISSORS: _scissor_finger,
}


def _pad(instrument: Instrument) -> tuple[float, float, float]:
    return (
        instrument.finger_half_thickness_m,
        instrument.finger_start_m,
        instrument.yaw_to_tip_m,
    )


def _shank(instrument: Instrument, *, half_width_m: float) -> list[trimesh.Trimesh]:
    """Return the eye about the yaw axis, on the finger's side of x = 0, and the arm to the pad."""
    half, start, _ = _pad(instrument)
    eye = _prism(_disc(2.5 * MM), _X, 0.15 * MM, 1.5 * MM)
    stations = np.array([(0.85 * MM, 0.8 * MM, 1.0 * MM), (0.0, half, start + 0.8 * MM)])
    sections = [_rounded(0.65 * MM, 1.5 * MM, 0.3 * MM), _rounded(half_width_m, half, 0.3 * MM)]
    rings = [
        np.column_stack([section + station[:2], np.full(len(section), station[2])])
        for station, section in zip(stations, sections, strict=True)
    ]
    return [eye, _loft(np.stack(rings))]


def _tooth(x: float, z: float, half_width: float, pitch: float, depth: float) -> trimesh.Trimesh:
    ridge = np.array([(depth, -0.5 * pitch), (0.0, 0.1 * pitch), (depth, 0.5 * pitch)])
    rings = [
        np.column_stack([np.full(3, x + side * 0.85 * half_width), ridge[:, 0], z + ridge[:, 1]])
        for side in (-1, 1)
    ]
    return _loft(np.stack(rings))


def _bar(x: float, y: float, z0: float, z1: float, half_x: float, half_y: float) -> trimesh.Trimesh:
    section = _rounded(half_x, half_y, 0.35 * min(half_x, half_y)) + np.array([x, y])
    return _prism(section, _Z, z0, z1)


def _cheek(
    forward: Array,
    axis: Array,
    offset: float,
    begin: float,
    eye: float,
    *,
    half_thickness: float = 0.7 * MM,
    radius: float = 2.7 * MM,
) -> trimesh.Trimesh:
    """Return a plate normal to `axis`, from `begin` along `forward`, rounded around a pin's eye."""
    side = 1.0 if eye > begin else -1.0
    arc = np.linspace(-np.pi / 2, np.pi / 2, 11)
    nose = np.column_stack([eye + side * radius * np.cos(arc), radius * np.sin(arc)])
    outline = np.vstack([nose, [(begin, radius), (begin, -radius)]])
    across = np.cross(axis, forward)
    flat = outline[:, :1] * forward + outline[:, 1:] * across
    return _loft(np.stack([flat + (offset + k * half_thickness) * axis for k in (-1, 1)]))


def _pin(axis: Array, half_length: float) -> Part:
    return Part(mesh=_prism(_disc(1.1 * MM), axis, -half_length, half_length), finish=DARK_STEEL)


def _steel(*meshes: trimesh.Trimesh) -> list[Part]:
    return [Part(mesh=mesh, finish=STEEL) for mesh in meshes]


def _transform_parts(parts: Sequence[Part], T: Array) -> list[Part]:
    return [Part(mesh=part.mesh.copy().apply_transform(T), finish=part.finish) for part in parts]


def _revolve(profile: Sequence[tuple[float, float]]) -> trimesh.Trimesh:
    """Return a solid of revolution about z from (z, radius) stations."""
    rings = [np.column_stack([_disc(r, 32), np.full(32, z)]) for z, r in profile]
    return _loft(np.stack(rings))


def _prism(section: Array, axis: Array, begin: float, end: float) -> trimesh.Trimesh:
    """Move a flat section (k, 2) along a coordinate axis; it spans the next two axes, in order."""
    u, v = np.roll(axis, 1), np.roll(axis, 2)
    flat = section[:, :1] * u + section[:, 1:] * v
    return _loft(np.stack([flat + begin * axis, flat + end * axis]))


def _sweep(path: Array, section: Array, *, binormal: Array) -> trimesh.Trimesh:
    """Sweep a section (k, 2) along a plane path (n, 3); it spans the path's normal and binormal."""
    normal = np.zeros_like(path)
    normal[:] = np.cross(binormal, unit(np.gradient(path, axis=0)))
    return _loft(path[:, None] + section[:, :1] * normal[:, None] + section[:, 1:] * binormal)


def _loft(rings: Array) -> trimesh.Trimesh:
    """Return a closed surface through rings (n, k, 3) of equal length, with flat convex ends."""
    n, k = rings.shape[:2]
    i, j = np.arange(n - 1)[:, None] * k, np.arange(k)
    a, b = i + j, i + (j + 1) % k
    sides = [np.stack([a, b, b + k], -1), np.stack([a, b + k, a + k], -1)]
    fan = np.column_stack([np.zeros(k - 2, int), np.arange(1, k - 1), np.arange(2, k)])
    faces = np.vstack([*(side.reshape(-1, 3) for side in sides), fan[:, ::-1], fan + (n - 1) * k])
    mesh = trimesh.Trimesh(rings.reshape(-1, 3), faces, process=False)
    if mesh.volume < 0:
        mesh.invert()
    return mesh


def _disc(radius: float, n: int = 20) -> Array:
    angle = np.linspace(0.0, 2 * np.pi, n, endpoint=False)
    return radius * np.column_stack([np.cos(angle), np.sin(angle)])


def _rounded(half_u: float, half_v: float, radius: float, n: int = 4) -> Array:
    """Return a rectangle (4 n, 2) with rounded corners, counter-clockwise."""
    corner = np.linspace(0.0, np.pi / 2, n)
    points = []
    for quarter, (u, v) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)]):
        angle = corner + quarter * np.pi / 2
        centre = np.array([u * (half_u - radius), v * (half_v - radius)])
        points.append(centre + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    return np.vstack(points)
