"""Published figures of SRT-H, the system that Calot reproduces.

Kim et al., "SRT-H: A hierarchical framework for autonomous surgery via language-conditioned
imitation learning", Science Robotics 10 (2025), arXiv 2505.10251.

The figures were measured on pig gallbladders, in wall time, without tool exchanges (as here). The
paper prints jerk in mm/s^3. Its size is that of third differences between frames at 30 Hz. Calot
therefore reads it as third differences (assumed: the paper does not say how it was computed).
"""

from __future__ import annotations

from dataclasses import dataclass

SOURCE = "Kim et al., Science Robotics 2025, arXiv 2505.10251"

PASSED, GALLBLADDERS = 8, 8
DURATIONS_S = (290.0, 315.0, 304.0, 300.0, 396.0, 318.0, 274.0, 337.0)
CORRECTIONS = (2, 8, 14, 3, 6, 12, 1, 5)


@dataclass(frozen=True, kw_only=True)
class PublishedTask:
    """Figures of one kind of task, by the robot and by one expert surgeon, in that order.

    Attributes:
        words: The words of these tasks of `planner.procedure.cholecystectomy.TASKS`, without the
            tube.
        path_m: Path of the instrument at work.
        jerk_m: Third difference between frames; None if the paper gives none.
    """

    name: str
    words: str
    time_s: tuple[float, float]
    path_m: tuple[float, float]
    jerk_m: tuple[float, float] | None = None


TASKS = (
    PublishedTask(
        name="first clip",
        words="clipping first clip",
        time_s=(18.1, 12.1),
        path_m=(0.0314, 0.0540),
        jerk_m=(2.544e-5, 3.058e-5),
    ),
    PublishedTask(
        name="third clip",
        words="clipping third clip",
        time_s=(25.0, 18.5),
        path_m=(0.0435, 0.0631),
    ),
    PublishedTask(
        name="go to the cut",
        words="go to the cutting position",
        time_s=(19.0, 13.0),
        path_m=(0.0444, 0.0473),
    ),
)
