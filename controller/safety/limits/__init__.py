"""Which limits must every motion keep? One limit a file, but one file for those of joints."""

from controller.safety.bounds import Limit
from controller.safety.limits.beside_tubes import SlowBesideTubes
from controller.safety.limits.joint_limits import Acceleration, JointRange, JointSpeed
from controller.safety.limits.keep_out import KeepOut
from controller.safety.limits.outer_shafts import OuterShafts
from controller.safety.limits.remote_centre import RemoteCentre
from controller.safety.limits.tip_speed import TipSpeed
from controller.safety.limits.tissue_force import TissueForce

LIMITS: tuple[Limit, ...] = (
    JointRange(),
    JointSpeed(),
    Acceleration(),
    TipSpeed(),
    RemoteCentre(),
    KeepOut(),
    OuterShafts(),
    TissueForce(),
    SlowBesideTubes(),
)
