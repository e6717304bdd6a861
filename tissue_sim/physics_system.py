"""The rigid-body solver, configured for articulations that feel forces."""

from __future__ import annotations

import sapien


def physics_system() -> sapien.physx.PhysxCpuSystem:
    """A CPU solver with projected Gauss-Seidel.

    The temporal variant reports link velocities of under half the true ones while a drive
    moves, and drive steps overshoot. The choice is global to the process.
    """
    config = sapien.physx.get_scene_config()
    config.enable_tgs = False
    sapien.physx.set_scene_config(config)
    return sapien.physx.PhysxCpuSystem()
