"""The rigid-body solver, configured for articulations that feel forces."""

from __future__ import annotations

import sapien


def physics_system() -> sapien.physx.PhysxCpuSystem:
    """A CPU solver with projected Gauss-Seidel.

    The temporal variant reports link velocities of under half the true ones while a drive
    moves, and drive steps overshoot. These settings are global to the process, so all of them
    are set, whatever another scene has left.
    """
    sapien.physx.set_shape_config(sapien.physx.PhysxShapeConfig())
    sapien.physx.set_body_config(sapien.physx.PhysxBodyConfig())
    config = sapien.physx.PhysxSceneConfig()
    config.enable_tgs = False
    sapien.physx.set_scene_config(config)
    return sapien.physx.PhysxCpuSystem()
