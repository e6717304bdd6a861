"""Record the field's history and conditions: what of the world's state is not in arrays."""

from __future__ import annotations

from dataclasses import dataclass, field, fields

from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.clip_slip import Pull
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import Grasp
from tissue_sim.surgery.injury import Injury, LimitReading
from tissue_sim.surgery.leak import Leak, Spill
from tissue_sim.surgery.parting import Opening
from tissue_sim.surgery.tear import Tear


@dataclass(frozen=True, kw_only=True)
class Record:
    """The field's history; a new record replaces it after each control step.

    Attributes:
        clip_loaded: Whether the applier holds a clip.
        jaws_opened: Whether the right jaws have opened since they last closed on tissue.
        clips: Held, detached and dropped clips, in order.
        pull: The test pull in progress.
        leaked_m3: Bile and blood lost so far.
        drained_m3: The gallbladder's share of the lost volume.
        spilt: Where the lost volume came from, also of leaks that are closed now.
        bed_rest_n: Force of the gallbladder on the liver bed before the first contact.
        broken_limits: Names of the limits that are currently exceeded.
        peaks: For each event with a limit above 0, the reading nearest to or furthest beyond it.
    """

    time_s: float = 0.0
    clip_loaded: bool = True
    jaws_opened: bool = False
    clips: tuple[Clip, ...] = ()
    cuts: tuple[Cut, ...] = ()
    tears: tuple[Tear, ...] = ()
    grasp: Grasp = field(default_factory=Grasp)
    pull: Pull | None = None
    leaks: tuple[Leak, ...] = ()
    leaked_m3: float = 0.0
    drained_m3: float = 0.0
    spilt: tuple[Spill, ...] = ()
    bed_rest_n: float = 0.0
    injuries: tuple[Injury, ...] = ()
    broken_limits: frozenset[str] = frozenset()
    peaks: tuple[LimitReading, ...] = ()

    @property
    def dropped_clips(self) -> int:
        """Return the number of clips that closed on nothing or fell from the applier."""
        return sum(clip.dropped for clip in self.clips)

    @property
    def openings(self) -> tuple[Opening, ...]:
        """Return the openings of tubes, from cuts and tears."""
        return (*self.cuts, *self.tears)


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Conditions that may change during an operation, except instruments: shares from 0 to 1.

    Attributes:
        grip: friction of the grasper's jaws over their friction when dry.
        dyed: share of the tissue's surface under red liquid; it changes only the appearance.

    Raises:
        ValueError: a share is outside 0 to 1.
    """

    grip: float = 1.0
    dyed: float = 0.0

    def __post_init__(self) -> None:
        for share in fields(self):
            value = getattr(self, share.name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"conditions: {share.name} = {value} must be from 0 to 1")
