"""Configure the rigid bodies of the arms: the solver, and the joints' drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import sapien

from tissue_sim.tools.instruments import Instrument


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


@dataclass(frozen=True, kw_only=True)
class Drive:
    """PD drive of one joint, in N m and rad; in N and m for the insertion.

    The reflected inertia of the motor (kg m2, kg) lets the simulator's few iterations share a load
    correctly between drive and contact. Without it, the reported force of a drive is too small.
    """

    stiffness: float
    reflected_inertia: float
    force_limit: float

    @property
    def damping(self) -> float:
        return DRIVE_LAG_S * self.stiffness


DRIVE_LAG_S = 0.005  # assumed: the lag behind a moving target
ARM_DRIVES = (  # assumed: 1 N bends the tip by less than 0.2 mm, a step overshoots by under 1 %
    Drive(stiffness=1e3, reflected_inertia=5e-3, force_limit=200.0),
    Drive(stiffness=1e3, reflected_inertia=5e-3, force_limit=200.0),
    Drive(stiffness=3e4, reflected_inertia=0.4, force_limit=500.0),
    Drive(stiffness=50.0, reflected_inertia=3e-4, force_limit=20.0),
    Drive(stiffness=50.0, reflected_inertia=3e-4, force_limit=10.0),
    Drive(stiffness=50.0, reflected_inertia=3e-4, force_limit=10.0),
)


def drives(instrument: Instrument) -> tuple[Drive, ...]:
    torque = instrument.jaw_torque_nm
    # assumed, as those of the arms: stiffness and inertia
    finger = Drive(stiffness=20.0, reflected_inertia=1e-4, force_limit=torque)
    return (*ARM_DRIVES, finger, finger)


def set_drive(joint: sapien.physx.PhysxArticulationJoint, drive: Drive) -> None:
    joint.set_drive_properties(
        stiffness=drive.stiffness,
        damping=drive.damping,
        force_limit=drive.force_limit,
        mode="force",
    )
    joint.set_friction(0.0)
    joint.set_armature(np.array([drive.reflected_inertia], np.float32))
