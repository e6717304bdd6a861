"""The plan of demonstrations: seed and mix determine each episode, and the order of its tasks.

In random orders of the procedure, instructions decide which tube is next.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any

import numpy as np

from planner.procedure.cholecystectomy import GRAB, TASKS
from planner.procedure.task import Task
from scenarios.catalogue import SCENARIOS
from tissue_sim.patient.tube_names import USUAL_TUBES
from tissue_sim.patient.variants import patient_of

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
ROLLOUT, FORK, FORKED_TURNS = "rollout", "fork", "forked-turns"
DECLINED = "declined"  # only the grab, on a patient who is left to a person
INTERVENTION = "intervention"  # in no mix: an episode in which a person intervened
KINDS = (
    NOMINAL, RECOVERY, CORRECTION, ORDER, TURNS, ROLLOUT, FORK, FORKED_TURNS, DECLINED, INTERVENTION
)  # fmt: skip
OF_THE_LEARNED = TURNS, ROLLOUT, FORKED_TURNS
IN_TURNS, FORKED = (TURNS, FORKED_TURNS), (FORK, FORKED_TURNS)
FAILING = ":"  # between a kind and its scenario: a failure of the recovery set, or a variant
MIXES: dict[str, tuple[str, ...]] = {  # the kinds alternate from seed to seed
    "nominal": (NOMINAL,),
    "textbook": (NOMINAL + FAILING + "textbook",),
    "recovery": (RECOVERY + FAILING,),
    "corrections": (CORRECTION,),
    "orders": (ORDER,),
    "turns": (TURNS,),
    "turns-recovery": (TURNS + FAILING,),
    "rollouts": (ROLLOUT, ROLLOUT + FAILING),
    "rollouts-recovery": (ROLLOUT + FAILING,),
    "forks": (FORK, FORK + FAILING),
    "forked-turns": (FORKED_TURNS, FORKED_TURNS + FAILING),
    "declined": (DECLINED,),
    "all": (NOMINAL, RECOVERY + FAILING, NOMINAL, CORRECTION),
}
LEARNED_MIXES = tuple(m for m, kinds in MIXES.items() if kinds[0].rstrip(FAILING) in OF_THE_LEARNED)


@dataclass(frozen=True, kw_only=True)
class PlannedDemonstration:
    """One episode to demonstrate.

    Attributes:
        seed: Seed of the patient and of all random numbers.
        kind: One of "nominal", "correction", "order", "turns", "rollout", "fork", "forked-turns",
            "declined". The forms "recovery:NAME", "turns:NAME", "rollout:NAME", "fork:NAME" and
            "forked-turns:NAME" name a perturbation, "nominal:NAME" a variant.
        noise: Whether bursts of noise disturb the motion.
        checkpoint: Checkpoint of the learned controller that takes turns with the expert, or acts
            alone; "" is the one that comes with Calot, if there is one.
        planner: Checkpoint of the learned planner; "" for the scripted planner.
        sense: A key of `scenarios.catalogue.SENSES`.
        cameras: Names of cameras (`tissue_sim.sensing.glance`); () films nothing.
    """

    seed: int
    kind: str
    noise: bool = True
    checkpoint: str = ""
    planner: str = ""
    sense: str = "tracked"
    cameras: tuple[str, ...] = ()

    @property
    def is_rollout(self) -> bool:
        """Return whether a learned controller acts alone; failed rollouts are kept as well."""
        return self.family == ROLLOUT

    @property
    def family(self) -> str:
        """Return the demonstration's entry in `KINDS`."""
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
    artery_below_m: float = math.inf,
    checkpoint: str = "",
    planner: str = "",
    **how: Any,
) -> list[PlannedDemonstration]:
    """Plan a demonstration for each training seed with a short enough artery.

    A larger number of episodes only adds some. Patients for whom a person must be called are left
    out, or are the only ones ("declined").

    Args:
        mix: A key of `MIXES`.
        first_seed: Seed of the first demonstration, unless its patient is left out.
        episodes: Number of demonstrations, fewer if the training seeds end.
        artery_below_m: Patients with a longer artery are left out.
        checkpoint, planner: Checkpoints, for the kinds in which a learned policy acts.
        how: Further fields of every `PlannedDemonstration`.
    """

    def planned(seed: int) -> PlannedDemonstration:
        by_expert = PlannedDemonstration(seed=seed, kind=_kind(mix, seed), **how)
        learned = by_expert.family in OF_THE_LEARNED
        return replace(by_expert, checkpoint=checkpoint, planner=planner) if learned else by_expert

    every = map(planned, range(first_seed, TRAINING_SEEDS.stop))
    return list(islice((d for d in every if _is_asked_for(d, artery_below_m)), episodes))


def _kind(mix: str, seed: int) -> str:
    """Return what the mix demonstrates on a seed; failures of the recovery set alternate."""
    kinds = MIXES[mix]
    kind = kinds[seed % len(kinds)]
    failure = RECOVERIES[seed // len(kinds) % len(RECOVERIES)]
    return kind + failure if kind.endswith(FAILING) else kind


def _is_asked_for(demonstration: PlannedDemonstration, artery_below_m: float) -> bool:
    """Return whether the patient is operable, unless declined, with an artery shorter than this."""
    from tissue_sim.outcome.room import why_call

    variant = SCENARIOS[demonstration.scenario].variant
    anatomy = patient_of(demonstration.seed, variant)
    declined = why_call(anatomy) is not None
    return anatomy.artery_length_m < artery_below_m and declined == (demonstration.kind == DECLINED)


def shuffled_order(rng: np.random.Generator) -> tuple[Task, ...]:
    """Draw an order: grab first; each tube's clips and cut keep their order, the tubes mix.

    Both tubes end with the last task of the usual order. A third tube follows, as usual.
    """
    left, right = ([task for task in TASKS if task.tube == tube] for tube in USUAL_TUBES)
    order = [GRAB]
    while left or right:
        of_tube = left if not right or (left and rng.random() < 0.5) else right
        order += of_tube[:2]
        del of_tube[:2]
    last = [task for task in TASKS if not task.is_optional][-1]
    return (*order, last, *(task for task in TASKS if task.is_optional))
