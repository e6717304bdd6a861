"""Tests of a procedure on tubes without room for three clips: one on either side of each cut."""

import pytest

from planner.procedure.cholecystectomy import CHOLECYSTECTOMY
from scenarios.catalogue import ORACLE
from scenarios.loop.episode_config import EpisodeConfig
from tests.scenarios.procedures import Procedure, run
from tissue_sim.outcome.clip_rule import FEWEST_CLIPS, needed_m
from tissue_sim.outcome.predicates import applier_on
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.patient.organ import TUBES

SHORT = EpisodeConfig(**ORACLE, seed=10_256, scenario="nominal")
TASKS = CHOLECYSTECTOMY.tasks_with(anatomy_from_seed(SHORT.seed).tubes)
SECOND_CLIPS = {task.index for task in TASKS if task.clip == 2}


@pytest.fixture(scope="module")
def short(tmp_path_factory: pytest.TempPathFactory) -> Procedure:
    return run(SHORT, tmp_path_factory.mktemp("fewer"))


@pytest.mark.slow
def test_it_passes_with_two_clips_on_each_tube(short: Procedure) -> None:
    tubes, record = short.world.tubes, short.world.record
    for tube in TUBES:
        applier = applier_on(short.world, tube)
        assert (
            needed_m(tube, applier, FEWEST_CLIPS) < tubes.length_m[tube] < needed_m(tube, applier)
        )
        stations = sorted(c.station_m for clip in record.clips if (c := clip.on(tube)))
        (cut,) = [cut for cut in record.cuts if cut.tube == tube]
        assert len(stations) == FEWEST_CLIPS
        assert stations[0] < cut.station_m < stations[1]
    assert short.result.success
    assert short.result.injuries == ()


def test_the_second_clips_are_left_out_and_the_other_tasks_succeed(short: Procedure) -> None:
    said = {step.instruction.task.index for step in short.steps}
    assert said == {task.index for task in TASKS} - SECOND_CLIPS
    for task in short.result.tasks:
        assert task.left_out == (task.index in SECOND_CLIPS)
        assert task.success == (not task.left_out)
    assert len(short.result.tasks) == len(TASKS)
