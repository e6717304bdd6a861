"""A procedure of three tasks from outside: a probe touches the left tube with closed jaws.

It brings a kind of task, its criteria, the expert's skill, and a tool; no file of Calot knows them.
"""

from functools import partial

from controller.expert.motion import before
from controller.expert.skills import SKILLS, go_to, stay
from controller.expert.targets import clip_pose
from planner.procedure.outcomes import OUTCOMES, TaskOutcome, structure_of
from planner.procedure.procedure import Procedure
from planner.procedure.task import Task
from planner.procedure.task_kind import KINDS, TaskKind
from planner.scene.observed_outcomes import OBSERVED
from tests.tissue_sim.kinds import POLYMER
from tissue_sim.sensing.observation import tip_to_tubes_m
from tissue_sim.surgery.grasp import RIGHT_FINGERS
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument

PROBE = "palpation_probe"
SHUT_RAD, SHUT_ENOUGH_RAD = 0.0, 0.05
NEAR_M, REACH_M = 0.004, 0.012
SPEED_M_S = 0.012


class TubeTouched(TaskOutcome):
    """Both closed fingers of the probe touch the task's tube."""

    def is_done(self, task, world):
        tube = world.tubes.vertices(structure_of(task, world))
        touching = set(world.tissue.host("contact_shape")[0].take(tube).tolist())
        shut = world.arms.joints[RIGHT_ARM, 6] <= SHUT_ENOUGH_RAD
        return bool(shut and touching & set(RIGHT_FINGERS))


def touch_observed(task, seen):
    """Return whether the right tip is observed at the tube."""
    return tip_to_tubes_m(seen) <= NEAR_M


def at_tube(world, tube, back_m):
    """Return the pose whose tip is `back_m` before the middle of the tube."""
    return before(clip_pose(world, tube, 2), 0.5 * POLYMER.length_m + back_m)


def touch(task, world, attempt):
    """Return the phases that bring the closed probe to the tube."""
    tube = structure_of(task, world)
    stand = partial(at_tube, tube=tube, back_m=REACH_M)
    there = partial(at_tube, tube=tube, back_m=0.5 * world.tubes.radius_m(tube))
    return (
        go_to(RIGHT_ARM, "in front of the tube", stand, SHUT_RAD),
        go_to(RIGHT_ARM, "at the tube", there, SHUT_RAD, speed_m_s=SPEED_M_S),
        stay(RIGHT_ARM),
    )


INSTRUMENTS[PROBE] = Instrument(
    name=PROBE,
    pitch_to_yaw_m=0.0091,
    yaw_to_tip_m=0.0155,
    wrist_pitch_limit_rad=1.4,
    wrist_yaw_limit_rad=1.4,
    jaw_range_rad=(-0.35, 1.4),
    finger_half_width_m=0.0012,
    finger_half_thickness_m=0.0010,
    finger_start_m=0.004,
    jaw_torque_nm=0.2,
)
KINDS["touch"] = TaskKind()
OUTCOMES["touch"] = TubeTouched()
OBSERVED["touch"] = touch_observed
SKILLS["touch"] = touch

TOUCHING = Procedure(
    name="touching",
    tasks=(
        Task(index=1, text="grabbing gallbladder", kind="grab", right_tool=PROBE),
        Task(index=2, text="touching left tube", kind="touch", tube="left", right_tool=PROBE),
        Task(index=3, text="going back left tube", kind="go_back", tube="left", right_tool=PROBE),
    ),
)
