"""Clips and cuts in the tissue and in the record, where the tools would make them."""

from dataclasses import replace

from tests.tissue_sim.kinds import POLYMER
from tests.tissue_sim.verification.bodies import astride
from tissue_sim.surgery.clip import latch
from tissue_sim.surgery.cut import BLADE_LENGTH_M, sever
from tissue_sim.surgery.leak import leaks
from tissue_sim.thresholds import CLIP_MIN_GAP_M
from tissue_sim.world import World

HALF_SECOND = 30  # tissue steps
LOW_M = 0.0030  # first clip, from the fixed end
NEXT_M = POLYMER.width_m + CLIP_MIN_GAP_M + 0.0002


def clip(world: World, tube: str, station_m: float, **how: float) -> None:
    T = astride(world.tubes, tube, station_m, **({"beyond_m": POLYMER.length_m / 2} | how))
    made = latch(
        world.tubes, T, POLYMER, number=len(world.record.clips) + 1, time_s=world.record.time_s
    )
    world.record = replace(world.record, clips=(*world.record.clips, made))
    settle(world)


def cut(world: World, tube: str, station_m: float, **how: float) -> None:
    T = astride(world.tubes, tube, station_m, **({"beyond_m": BLADE_LENGTH_M / 2} | how))
    made = sever(world.tubes, T, time_s=world.record.time_s)
    world.record = replace(world.record, cuts=(*world.record.cuts, *made))
    settle(world, 5)


def settle(world: World, steps: int = HALF_SECOND) -> None:
    for _ in range(steps):
        world.tissue.step()
    r = world.record
    world.record = replace(r, leaks=leaks(world.tubes, r.clips, r.cuts))


def three_stations(world: World, tube: str) -> tuple[float, float, float]:
    return LOW_M, LOW_M + NEXT_M, world.tubes.length_m[tube] - 0.0045


def three_clips(world: World, tube: str) -> None:
    for station in three_stations(world, tube):
        clip(world, tube, station)
