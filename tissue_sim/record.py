"""What happened in the field so far: the world's state that is not in an array."""

from __future__ import annotations

from dataclasses import dataclass, field

from tissue_sim.clip import Clip
from tissue_sim.cut import Cut
from tissue_sim.grasp import Grasp
from tissue_sim.injury import Injury
from tissue_sim.leak import Leak


@dataclass(frozen=True, kw_only=True)
class Pull:
    """A test pull at a clip.

    Attributes:
        number: the clip's.
        force_n: how hard it is pulled now.
        holds_n: what its grip held before the pull: pulling tightens the tissue, not the clip.
    """

    number: int
    force_n: float
    holds_n: float


@dataclass(frozen=True, kw_only=True)
class Record:
    """The field's history, replaced as a whole after each control step.

    Attributes:
        clip_loaded: the applier holds a clip.
        jaws_opened: the right jaws have opened since they last closed on something.
        pulls: the test pulls under way.
        leaked_m3: bile and blood so far.
        broken_limits: names of the limits that are exceeded now.
    """

    time_s: float = 0.0
    clip_loaded: bool = True
    jaws_opened: bool = False
    clips: tuple[Clip, ...] = ()
    cuts: tuple[Cut, ...] = ()
    grasp: Grasp = field(default_factory=Grasp)
    pulls: tuple[Pull, ...] = ()
    leaks: tuple[Leak, ...] = ()
    leaked_m3: float = 0.0
    injuries: tuple[Injury, ...] = ()
    broken_limits: frozenset[str] = frozenset()
