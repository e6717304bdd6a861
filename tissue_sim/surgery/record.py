"""What happened in the field so far: the world's state that is not in an array."""

from __future__ import annotations

from dataclasses import dataclass, field

from tissue_sim.surgery.clip import Clip
from tissue_sim.surgery.cut import Cut
from tissue_sim.surgery.grasp import Grasp
from tissue_sim.surgery.injury import Injury
from tissue_sim.surgery.leak import Leak
from tissue_sim.surgery.parting import Opening
from tissue_sim.surgery.slip import Pull
from tissue_sim.surgery.tear import Tear


@dataclass(frozen=True, kw_only=True)
class Record:
    """The field's history, replaced as a whole after each control step.

    Attributes:
        clip_loaded: the applier holds a clip.
        jaws_opened: the right jaws have opened since they last closed on something.
        clips: held, fallen off and dropped ones, in order.
        pull: the test pull under way.
        leaked_m3: bile and blood so far.
        drained_m3: the gallbladder's part in it.
        bed_rest_n: the gallbladder's own press on the liver bed, before anyone touched it.
        broken_limits: names of the limits that are exceeded now.
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
    bed_rest_n: float = 0.0
    injuries: tuple[Injury, ...] = ()
    broken_limits: frozenset[str] = frozenset()

    @property
    def dropped_clips(self) -> int:
        """Clips that closed on nothing or fell from the applier."""
        return sum(clip.dropped for clip in self.clips)

    @property
    def openings(self) -> tuple[Opening, ...]:
        """Where tubes stand open, by cut or tear."""
        return (*self.cuts, *self.tears)
