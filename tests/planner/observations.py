"""Made-up observations: two straight tubes side by side, with any number of clips on each."""

from dataclasses import replace

import numpy as np

from tissue_sim.patient.tube_names import TUBES, Tube
from tissue_sim.sensing.observation import (
    MAX_CLIPS,
    N_POINTS,
    POINTS,
    SAC_POINTS,
    TRUNK_POINTS,
    TUBE_POINTS,
    Observation,
)
from tissue_sim.thresholds import HELD_PINCH_N, RETRACTED_M


def clipped(
    left: int = 0,
    right: int = 0,
    time_s: float = 0.0,
    apart_m: float = 0.016,
    duct: Tube = "left",
) -> Observation:
    """Return an observation of two parallel tubes of 28 mm with clips on them.

    The clips are between tracked points, 1 mm off the middle line. The infundibulum goes on from
    the duct's upper end.
    """
    tubes_m = {
        side: np.column_stack(
            [
                np.full(TUBE_POINTS, x),
                np.linspace(0.0, 0.028, TUBE_POINTS),
                np.full(TUBE_POINTS, 0.15),
            ]
        )
        for side, x in (("left", apart_m / 2), ("right", -apart_m / 2))
    }
    clips_m = np.zeros((MAX_CLIPS, 3))
    for k, (side, n) in enumerate(
        [("left", n) for n in range(left)] + [("right", n) for n in range(right)]
    ):
        clips_m[k] = tubes_m[side][0] + [0.001, 0.006 + 0.006 * n, 0.0]
    return Observation(
        time_s=time_s,
        joints=np.zeros((2, 7)),
        tips_endoscope=np.tile(np.eye(4), (2, 1, 1)),
        forces_n=np.zeros((2, 3)),
        pinch_n=2.0 * HELD_PINCH_N,
        tools=("grasper", "clip_applier"),
        clip_loaded=True,
        tubes_m=np.stack([tubes_m["left"], tubes_m["right"], np.zeros((TUBE_POINTS, 3))]),
        sac_m=tubes_m[duct][-1] + np.linspace(0.0, 0.01, SAC_POINTS)[:, None] * [0.0, 1.0, 0.0],
        common_bile_duct_m=trunk_m(tubes_m[duct]),
        hepatic_artery_m=trunk_m(tubes_m["right" if duct == "left" else "left"]),
        clips_m=clips_m,
        n_clips=left + right,
        severed=np.zeros(3, bool),
        tube_radius_m=np.array([0.0015, 0.0015, 0.0]),
        rest_length_m=np.array([0.028, 0.028, 0.0]),
        hidden=np.arange(N_POINTS) // TUBE_POINTS == TUBES.index("third"),
    )


def at_work(
    left: int = 0,
    right: int = 0,
    *,
    time_s: float = 0.0,
    back: bool = False,
    held: bool = True,
) -> Observation:
    """Return an observation with clips, the right tip at the tubes or back, the grasp held."""
    made = writable(clipped(left, right, time_s))
    made.tips_endoscope[1, :3, 3] = made.tube_m("left")[3]
    made.tips_endoscope[1, 2, 3] -= 1.1 * RETRACTED_M if back else 0.0
    return replace(made, pinch_n=(1.2 if held else 0.4) * HELD_PINCH_N)


def writable(observation: Observation) -> Observation:
    """Return a copy whose arrays can be written into, as those of no observation else."""
    made = replace(observation)
    for name, value in vars(made).items():
        if isinstance(value, np.ndarray):
            vars(made)[name] = value.copy()
    return made


def third_tube(observation: Observation, clips: int = 0) -> Observation:
    """Return the observation with a third tube far behind the right one, and clips on it."""
    made = writable(observation)
    made.tubes_m[2] = made.tubes_m[1] + [-0.016, 0.0, 0.01]
    for k in range(clips):
        made.clips_m[made.n_clips + k] = made.tubes_m[2, 0] + [0.001, 0.006 + 0.006 * k, 0.0]
    made.tube_radius_m[2], made.rest_length_m[2] = 0.0006, 0.028
    made.hidden[:] = False
    return replace(made, third_tube=1.0, n_clips=made.n_clips + clips)


def with_tube(observation: Observation, tube: Tube, tube_m: np.ndarray) -> Observation:
    """Return the observation with other points (8, 3) of a tube."""
    tubes_m = observation.tubes_m.copy()
    tubes_m[TUBES.index(tube)] = tube_m
    return replace(observation, tubes_m=tubes_m)


def trunk_m(branch_m: np.ndarray) -> np.ndarray:
    """Return points (4, 3) of a straight trunk across a branch's fixed end."""
    return branch_m[0] + np.linspace(-0.02, 0.02, TRUNK_POINTS)[:, None] * [1.0, 0.0, 0.0]


def shifted(observation: Observation, by_m: np.ndarray) -> Observation:
    """Return the observation with every place shifted by `by_m` (3,)."""
    tips = observation.tips_endoscope.copy()
    tips[:, :3, 3] += by_m
    return replace(
        observation,
        tips_endoscope=tips,
        **{name: getattr(observation, name) + by_m for name in POINTS},
    )
