"""Attack one patient, each time once without the safety filter and once with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from controller.safety.exemption import must_not_meet, worked_on
from controller.safety.filter import SafetyFilter
from controller.safety.filter_sense import registration_of
from controller.safety.geometry.collision import ACTIVATION_M, CollisionModel
from controller.safety.ledger import Entry
from controller.safety.obstacles import registered, surroundings_of
from planner.instruction import TASKS, Instruction
from scenarios.bench.trials.attack import ATTACKS, Attack, AttackTargets, aims, random_start
from scenarios.bench.trials.run_trials import Trial
from tissue_sim.frames import Array
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.tools.arms import JointCommand
from tissue_sim.world import World

AT_REST = 18  # attacks on tissue at rest: each kind twice
IN_WORLD = 2  # attacks in the moving world, unless more are asked for
STEPS = 40
LOOKS = 4  # checks of the commanded motion in each step, as often as the world moves the drives
CLEAR_M = 0.001  # minimum distance from every keep-out at the start
TRIES = 10_000
ANY_NUMBER = range(10_000)


@dataclass(kw_only=True)
class AttackRun:
    """Result of one attack so far.

    Attributes:
        depth_m: Obstacle -> largest depth of an instrument that must keep out of it.
        beyond_range: Largest excess of a commanded joint over its range; rad or m.
        tip_speed_m_s: Largest commanded tip speed.
        entries: The filter's ledger entries.
    """

    depth_m: dict[str, float] = field(default_factory=dict)
    beyond_range: float = 0.0
    tip_speed_m_s: float = 0.0
    entries: list[Entry] = field(default_factory=list)

    @property
    def deepest_m(self) -> float:
        """Return the largest depth in any obstacle."""
        return max(self.depth_m.values(), default=0.0)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """The same attack without and with the filter; `in_world`: measured in the moving world."""

    kind: str
    in_world: bool
    without: AttackRun
    filtered: AttackRun


@dataclass(frozen=True, kw_only=True)
class AttackTrial(Trial):
    """All attacks on one patient."""

    pairs: tuple[Pair, ...] = ()


def run_trial(seed: int, in_world: int = IN_WORLD) -> AttackTrial:
    """Run all attacks on a seed's patient, `in_world` of them in the moving world."""
    return AttackTrial(seed=seed, pairs=tuple(AttackedPatient(seed).pairs(in_world)))


class AttackedPatient:
    """A seed's patient, under many attacks."""

    def __init__(self, seed: int) -> None:
        self._seed, self._world = seed, World()
        self._world.reset(anatomy_from_seed(seed))
        self._begun = self._world.state()
        self._rigid = registered(self._world)
        self._model = CollisionModel(self._rigid, self._world.arms.T_world_rcm)
        self._filter = SafetyFilter(registration_of(self._world))

    def pairs(self, n_in_world: int = IN_WORLD) -> Iterator[Pair]:
        """Yield every attack without and with the filter; the kinds in the world vary by seed."""
        kinds = list(ATTACKS)
        for k in range(AT_REST + n_in_world):
            kind, in_world = kinds[(k + n_in_world * self._seed) % len(kinds)], k >= AT_REST
            without, filtered = (self._run(k, kind, in_world, f) for f in (False, True))
            yield Pair(kind=kind, in_world=in_world, without=without, filtered=filtered)

    def ask_at_random(self, rng: np.random.Generator, pairs: range) -> None:
        """Submit one random request at rest to the filter; `pairs` is the range of near pairs."""
        self._begin(rng)
        start = self._clear_start(rng, pairs)
        kind = list(ATTACKS)[rng.integers(len(ATTACKS))]
        asked = ATTACKS[kind](self._targets(), start, rng)(start)
        self._filter.allow(start, asked, self._instruction, self._world.observe())

    def _run(self, number: int, kind: str, in_world: bool, filtered: bool) -> AttackRun:
        rng = np.random.default_rng([self._seed, number])
        self._begin(rng)
        start = self._world.target if in_world else self._clear_start(rng)
        attack = ATTACKS[kind](self._targets(), start, rng)
        return self._follow(attack, start, in_world, filtered)

    def _begin(self, rng: np.random.Generator) -> None:
        """Restore the untouched patient, draw an instruction, and mount its tool."""
        self._world.restore(self._begun)
        task = TASKS[rng.integers(len(TASKS))]
        self._world.equip(task.right_tool)
        self._instruction = Instruction(task=task)
        self._filter.restart()

    def _follow(self, attack: Attack, start: Array, in_world: bool, filtered: bool) -> AttackRun:
        run, joints, step_s = AttackRun(), start, self._world.config.control_step_s
        limits = self._world.arms.limits
        for _ in range(STEPS):
            before, asked = joints, attack(joints)
            joints = self._world.arms.limited(asked)
            if filtered:
                allowed = self._filter.allow(
                    before, asked, self._instruction, self._world.observe()
                )
                joints = allowed.joints
                run.entries += [allowed.entry] if allowed.entry else []
            for seen in self._move(before, joints, in_world):
                for obstacle, depth_m in self._depths(seen):
                    run.depth_m[obstacle] = max(depth_m, run.depth_m.get(obstacle, 0.0))
            outside = np.maximum(limits[..., 0] - joints, joints - limits[..., 1])
            run.beyond_range = max(run.beyond_range, float(outside.max()))
            moved_m = np.linalg.norm(self._tips_m(joints) - self._tips_m(before), axis=1)
            run.tip_speed_m_s = max(run.tip_speed_m_s, float(moved_m.max()) / step_s)
        return run

    def _move(self, before: Array, joints: Array, in_world: bool) -> Sequence[Array]:
        """Carry out a command; return the arms' joints (2, 7) on the way."""
        arms = self._world.arms
        if in_world:
            self._world.step(JointCommand(joints=joints))
            return [arms.joints]
        arms.set_joints(joints)
        return [before + share * (joints - before) for share in np.linspace(0, 1, LOOKS + 1)[1:]]

    def _depths(self, joints: Array, within_m: float = 0.0) -> Iterator[tuple[str, float]]:
        """Yield obstacle and depth of each pair that must not touch."""
        instruments, around = self._world.arms.mounted, surroundings_of(self._world)
        near = self._model.near(joints, instruments, around, within_m=within_m)
        work = worked_on(self._instruction.task, self._world.observe())
        for k in np.flatnonzero(near.foremost).tolist():
            obstacle = near.names[near.what[k]]
            if must_not_meet(int(near.arm[k]), int(near.link[k]), obstacle, work):
                yield obstacle, -float(near.distance_m[k])

    def _clear_start(self, rng: np.random.Generator, pairs: range = ANY_NUMBER) -> Array:
        """Move the arms to joints (2, 7) outside every keep-out with near pairs in `pairs`."""
        for _ in range(TRIES):
            joints = random_start(rng)
            depths_m = [depth_m for _, depth_m in self._depths(joints, ACTIVATION_M)]
            if len(depths_m) in pairs and max(depths_m, default=-np.inf) < -CLEAR_M:
                self._world.arms.set_joints(joints)
                return joints
        raise RuntimeError(f"seed {self._seed}: no clear start in {TRIES} tries")

    def _targets(self) -> AttackTargets:
        return AttackTargets(
            T_world_rcm=self._world.arms.T_world_rcm,
            instruments=self._world.arms.mounted,
            points_m=aims(self._rigid, surroundings_of(self._world)),
        )

    def _tips_m(self, joints: Array) -> Array:
        targets = self._targets()
        return np.stack([targets.tip_m(arm, joints[arm]) for arm in range(2)])
