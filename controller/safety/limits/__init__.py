"""Which limits must every motion keep?"""

from controller.safety.bounds import Limit
from controller.safety.limits import arms, tissue
from controller.safety.limits.keep_out import KEEP_OUT, keep_out_of_obstacles

LIMITS: dict[str, Limit] = {
    "joint range": arms.keep_joint_range,
    "joint speed": arms.limit_joint_speed,
    "acceleration": arms.limit_acceleration,
    "tip speed": arms.limit_tip_speed,
    "remote centre": arms.hold_remote_centre,
    KEEP_OUT: keep_out_of_obstacles,
    "outer shafts": arms.keep_outer_shafts_apart,
    "tissue force": tissue.limit_force,
    "slow beside tubes": tissue.slow_beside_tubes,
}
