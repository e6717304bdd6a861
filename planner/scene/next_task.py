"""Find the next task, on a tube and in the whole procedure, and its tool, as observed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from planner.command import Deed
from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from planner.procedure.task import Task
from planner.scene.duct_side import structure_seen, tubes_in_order
from tissue_sim.outcome.clip_rule import USUAL_CLIPS, clips_needed
from tissue_sim.patient.tube_names import Tube
from tissue_sim.sensing.observation import MAX_CLIPS, Observation
from tissue_sim.sensing.polyline import distance_to_line_m
from tissue_sim.tools.clips import CLIPS, ClipKind
from tissue_sim.tools.instruments import INSTRUMENTS, Instrument, applier_for, applier_of, clip_of

RATHER_MORE = 1.0  # standard deviations of a length; chosen on tuning patients
ON_TUBE_M = 0.004  # from a clip's middle to the tube's centreline; assumed, about a tube's width


class NotNowError(ValueError):
    """A command cannot be carried out now; the message gives a person the reason."""


class DoneAlreadyError(NotNowError):
    """A commanded act is already done; the message says so to a person."""


def next_task(deed: Deed, tube: Tube, observation: Observation) -> Task:
    """Return the task that carries out the deed.

    Args:
        deed: The deed, to clip or to cut.
        tube: The tube of the deed.
        observation: The present observation. A tube's needed clips follow from its length at rest.

    Raises:
        DoneAlreadyError: The tube is cut, or has all its clips.
        NotNowError: The tube is not there, or lacks the clips that a cut needs.
    """
    require_there(tube, observation)
    n_clips = clips_on(tube, observation)
    n_needed = clips_needed_on(tube, observation)
    if observation.is_severed(tube):
        raise DoneAlreadyError(f"the {tube} tube is cut already")
    if deed == "clip" and n_clips >= n_needed:
        raise DoneAlreadyError(f"the {tube} tube has its {n_needed} clips")
    if deed == "cut" and n_clips < n_needed:
        raise NotNowError(f"the {tube} tube has {n_clips} of the {n_needed} clips a cut needs")
    last = USUAL_CLIPS if n_clips == n_needed - 1 else n_clips + 1  # the gallbladder's clip
    clip = last if deed == "clip" else None
    return CHOLECYSTECTOMY.of(deed, tube, clip)


def require_there(tube: Tube | None, observation: Observation) -> None:
    """Require that a patient has a tube.

    Raises:
        NotNowError: The tube is not there.
    """
    if tube is not None and tube not in observation.tubes:
        raise NotNowError(f"there is no {tube} tube here")


def next_of_all(observation: Observation) -> Task | None:
    """Return the procedure's first clip or cut that is not observed as done; None if all are."""
    for tube in tubes_in_order(observation):
        if not observation.is_severed(tube):
            lacks = clips_on(tube, observation) < clips_needed_on(tube, observation)
            return next_task("clip" if lacks else "cut", tube, observation)
    return None


def clips_needed_on(tube: Tube, observation: Observation, *, stds: float = RATHER_MORE) -> int:
    """Return how many clips a tube needs by its length at rest, longer by some deviations.

    A third clip usually finds its place on a tube that is a little too short for three clips. A
    tube with one clip too few is not done.
    """
    length_m = observation.length_m(tube) + stds * observation.length_std_m(tube)
    structure, applier = structure_seen(tube, observation), applier_on(tube, observation)
    return clips_needed(structure, length_m, applier)


def applier_on(tube: Tube, observation: Observation) -> Instrument:
    """Return the applier for a tube: of the first clip on it, else by the tube's seen width."""
    kinds = zip(clip_kinds(tube, observation), lying_on(tube, observation), strict=True)
    kind = next((kind for kind, lies in kinds if lies), None)
    return applier_of(kind) if kind else _applier_by_width(tube, observation)


def clip_kinds(tube: Tube, observation: Observation) -> list[ClipKind]:
    """Return the kinds of the clips in `clips_m`; an unknown one is taken for the tube's own."""
    own = clip_of(_applier_by_width(tube, observation))
    n = min(observation.n_clips, MAX_CLIPS)
    known = [CLIPS[name] for name in observation.clip_kinds[-MAX_CLIPS:]]
    return known if len(known) == n else [own] * n


def _applier_by_width(tube: Tube, observation: Observation) -> Instrument:
    return applier_for(2.0 * observation.radius_m(tube))


def clips_on(tube: Tube, observation: Observation) -> int:
    """Return how many clips lie on a tube."""
    return int(lying_on(tube, observation).sum())


def lying_on(tube: Tube, observation: Observation) -> NDArray[np.bool_]:
    """Return which clips (n,) lie on a tube: near the tube, and nearer than to each other tube."""
    clips_m = observation.clips_m[: min(observation.n_clips, MAX_CLIPS)]
    away_m = {t: distance_to_line_m(clips_m, observation.tube_m(t)) for t in observation.tubes}
    own_m = away_m.pop(tube, np.full(len(clips_m), np.inf))
    return (own_m <= ON_TUBE_M) & (own_m < np.min([*away_m.values()], axis=0))


class ToolChoice:
    """Chooses the tools of one patient's tasks, as a scrub nurse does.

    A task that clips names any applier. The smallest kind of clip for the tube's width is chosen
    when the tube's first clip is due, and stays. So noise of the observation never makes the tools
    alternate.

    Attributes:
        appliers: Name of the applier of each tube whose first clip was due.
    """

    def __init__(self) -> None:
        self.appliers: dict[str, str] = {}

    def tool(self, task: Task, observation: Observation) -> str:
        """Return the name of the tool for a task.

        A task without a clip takes the mounted tool if that can do the same.
        """
        mounted = observation.right_instrument
        if not task.places_clip or task.tube is None:
            same = mounted.deed == INSTRUMENTS[task.right_tool].deed
            return mounted.name if same else task.right_tool
        if task.tube not in self.appliers:
            self.appliers[task.tube] = applier_on(task.tube, observation).name
        return self.appliers[task.tube]
