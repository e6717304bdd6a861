"""A small field of obstacles: a flat liver far below, a wall and one tube; no simulator."""

from typing import NamedTuple

import numpy as np

from controller.safety.geometry.collision import CollisionModel
from controller.safety.geometry.rigid_surface import RigidSurface, port_wall
from controller.safety.obstacles import RigidSurroundings, Surroundings, chained
from tissue_sim.tools.arms import LEFT_ARM, RIGHT_ARM, port_pose
from tissue_sim.tools.instruments import INSTRUMENTS

T_WORLD_RCM = np.stack([port_pose(LEFT_ARM), port_pose(RIGHT_ARM)])
TOOLS = (INSTRUMENTS["grasper"], INSTRUMENTS["clip_applier"])
HOME = np.array([[0.0, 0.0, 0.09, 0.0, 0.0, 0.0, 0.3], [0.0, 0.0, 0.09, 0.0, 0.0, 0.0, 0.3]])
EYE = np.eye(3)


def plane(point, normal, half_size=0.2, cells=8):
    """Return a square surface about a point, free on the side of its normal."""
    normal = normal / np.linalg.norm(normal)
    across = np.cross(normal, EYE[np.argmin(np.abs(normal))])
    across /= np.linalg.norm(across)
    u, v = np.meshgrid(*[np.linspace(-half_size, half_size, cells + 1)] * 2, indexing="ij")
    points = point + u[..., None] * across + v[..., None] * np.cross(normal, across)
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return RigidSurface(points_m=points.reshape(-1, 3), triangles=triangles)


def rigid(liver=None):
    far_below = plane(np.array([0.0, 0.0, -0.5]), EYE[2])
    return RigidSurroundings(
        liver=far_below if liver is None else liver,
        port_wall=port_wall(T_WORLD_RCM[:, :3, 3]),
        assistant_m=np.array([[0.0, 0.0, -0.6], [0.0, 0.0, -0.7]]),
    )


def model(liver=None):
    return CollisionModel(rigid(liver), T_WORLD_RCM)


class Chain(NamedTuple):
    """Holds n capsules: their starts (n, 3), ends (n, 3) and radii (n,)."""

    start_m: np.ndarray
    end_m: np.ndarray
    radius_m: np.ndarray


def chain(points, radius_m):
    """Return the capsules through points (n, 3)."""
    points = np.asarray(points, float)
    return Chain(points[:-1], points[1:], np.broadcast_to(radius_m, len(points) - 1))


def surroundings(moved_m=(0.0, 0.0, 0.0), **chains):
    chains = chains or {"artery": chain([[1.0, 0.0, 0.0], [1.0, 0.0, 0.1]], 0.001)}
    moved = {"liver": np.array(moved_m), "port wall": np.zeros(3)}
    lengths = {name: len(radii) for name, (_, _, radii) in chains.items()}
    parts = (np.concatenate(part) for part in zip(*chains.values(), strict=True))
    return Surroundings(moved_m=moved, capsules=chained(lengths, *parts))


def to_points_m(links, points_m):
    """Return distances (8, n) of the links' surfaces to points (n, 3), world frame; < 0 inside."""
    local = (points_m - links.centre_m[:, None]) @ links.R_world_core
    reach = links.half_size_m[:, None]
    away = local - np.clip(local, -reach, reach)
    return np.linalg.norm(away, axis=-1) - links.radius_m[:, None]
