"""Configure the rigid-body solver for articulations under external forces."""

from __future__ import annotations

import sapien


def physics_system() -> sapien.physx.PhysxCpuSystem:
    """Return a CPU solver with projected Gauss-Seidel.

    While a drive moves, the temporal variant (TGS) reports link velocities of less than half the
    true ones, and its drive steps overshoot. These settings are global to the process. So all of
    them are set, in case another scene has changed them.
    """
    sapien.physx.set_shape_config(sapien.physx.PhysxShapeConfig())
    sapien.physx.set_body_config(sapien.physx.PhysxBodyConfig())
    config = sapien.physx.PhysxSceneConfig()
    config.enable_tgs = False
    sapien.physx.set_scene_config(config)
    return sapien.physx.PhysxCpuSystem()
