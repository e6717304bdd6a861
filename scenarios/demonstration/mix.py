"""Which episodes are demonstrated: seed and mix determine each one."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from tissue_sim.patient.anatomy import anatomy_from_seed

TRAINING_SEEDS = range(10_000)
RECOVERIES = (
    "grasp-missed-above",
    "grasp-missed-below",
    "wrong-tube",
    "both-tubes",
    "overshoot",
    "grasp-slip",
    "clip-dropped",
)
NOMINAL, RECOVERY, CORRECTION = "nominal", "recovery", "correction"
ORDER, TURNS = "order", "turns"
ROLLOUT = "rollout"
KINDS = NOMINAL, RECOVERY, CORRECTION, ORDER, TURNS, ROLLOUT
OF_THE_LEARNED = TURNS, ROLLOUT
FAILING = ":"  # between a kind and the name of a failure of the recovery set
MIXES: dict[str, tuple[str, ...]] = {  # the kinds alternate from seed to seed
    "nominal": (NOMINAL,),
    "recovery": (RECOVERY + FAILING,),
    "corrections": (CORRECTION,),
    "orders": (ORDER,),
    "turns": (TURNS,),
    "turns-recovery": (TURNS + FAILING,),
    "rollouts": (ROLLOUT, ROLLOUT + FAILING),
    "rollouts-recovery": (ROLLOUT + FAILING,),
    "all": (NOMINAL, RECOVERY + FAILING, NOMINAL, CORRECTION),
}
LEARNED_MIXES = tuple(m for m, kinds in MIXES.items() if kinds[0].rstrip(FAILING) in OF_THE_LEARNED)


@dataclass(frozen=True, kw_only=True)
class PlannedDemonstration:
    """One episode to demonstrate.

    Attributes:
        seed: of the patient and of all random numbers.
        kind: "nominal", "correction", "order", "turns", "rollout"; or "recovery:", "turns:",
            "rollout:" and a perturbation's name.
        noise: whether bursts of noise disturb the motion.
        checkpoint: of the learned controller that takes turns with the expert, or acts alone; ""
            is the one that comes with Calot.
        planner: checkpoint of the learned planner; "" for the scripted planner.
    """

    seed: int
    kind: str
    noise: bool = True
    checkpoint: str = ""
    planner: str = ""

    @property
    def is_rollout(self) -> bool:
        """Return whether a learned controller acts alone; its failures are kept, too."""
        return self.family == ROLLOUT

    @property
    def family(self) -> str:
        """Return which of `KINDS` it is."""
        return self.kind.partition(FAILING)[0]

    @property
    def scenario(self) -> str:
        """Return the key of its scenario in the catalogue."""
        return self.kind.partition(FAILING)[2] or "nominal"

    @property
    def name(self) -> str:
        """Return the name of its files; they sort by seed."""
        return f"{self.seed:05d}-{self.kind.replace(':', '-')}{'' if self.noise else '-quiet'}"


def demonstrations(
    mix: str,
    first_seed: int,
    episodes: int,
    *,
    noise: bool = True,
    checkpoint: str = "",
    planner: str = "",
    artery_below_m: float = math.inf,
) -> list[PlannedDemonstration]:
    """Plan one for each training seed with a short enough artery; more episodes only add some.

    Patients for whom a person must be called are left out.
    """
    turns = MIXES[mix]
    made = []
    for seed in islice(_patients(first_seed, artery_below_m), episodes):
        kind = turns[seed % len(turns)]
        learned = kind.rstrip(FAILING) in OF_THE_LEARNED
        if kind.endswith(FAILING):
            kind += RECOVERIES[seed // len(turns) % len(RECOVERIES)]
        made.append(
            PlannedDemonstration(
                seed=seed,
                kind=kind,
                noise=noise,
                checkpoint=checkpoint if learned else "",
                planner=planner if learned else "",
            )
        )
    return made


def _patients(first_seed: int, artery_below_m: float) -> Iterator[int]:
    """Yield training seeds of operable patients whose artery is shorter than this."""
    from tissue_sim.outcome.room import why_call

    for seed in range(first_seed, TRAINING_SEEDS.stop):
        anatomy = anatomy_from_seed(seed)
        if anatomy.artery_length_m < artery_below_m and why_call(anatomy) is None:
            yield seed
