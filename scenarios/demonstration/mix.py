"""Which episodes are demonstrated: what each is called for by its seed and the mix alone."""

from __future__ import annotations

from dataclasses import dataclass

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
KINDS = NOMINAL, RECOVERY, CORRECTION, ORDER, TURNS
MIXES: dict[str, tuple[str, ...]] = {  # taken by turns
    "nominal": (NOMINAL,),
    "recovery": (RECOVERY,),
    "corrections": (CORRECTION,),
    "orders": (ORDER,),
    "turns": (TURNS,),
    "all": (NOMINAL, RECOVERY, NOMINAL, CORRECTION),
}


@dataclass(frozen=True, kw_only=True)
class Demonstration:
    """One episode to demonstrate.

    Attributes:
        seed: of the patient and of everything random.
        kind: "nominal", "recovery:" and the perturbation's name, "correction", "order" or "turns".
        noise: whether bursts of noise disturb the motion.
        checkpoint: of the learned controller that takes turns with the expert; "" where none does.
    """

    seed: int
    kind: str
    noise: bool = True
    checkpoint: str = ""

    @property
    def scenario(self) -> str:
        """A key of the scenarios' catalogue."""
        return self.kind.partition(":")[2] or "nominal"

    @property
    def name(self) -> str:
        """Of its files: they sort by seed."""
        return f"{self.seed:05d}-{self.kind.replace(':', '-')}{'' if self.noise else '-quiet'}"


def demonstrations(
    mix: str, first_seed: int, episodes: int, *, noise: bool = True, checkpoint: str = ""
) -> list[Demonstration]:
    """One for each seed, so that more episodes later only add to them."""
    turns = MIXES[mix]
    made = []
    for seed in range(first_seed, first_seed + episodes):
        kind = turns[seed % len(turns)]
        if kind == RECOVERY:
            kind = f"{RECOVERY}:{RECOVERIES[seed // len(turns) % len(RECOVERIES)]}"
        of_turns = checkpoint if kind == TURNS else ""
        made.append(Demonstration(seed=seed, kind=kind, noise=noise, checkpoint=of_turns))
    return made
