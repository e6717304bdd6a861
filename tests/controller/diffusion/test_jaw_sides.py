"""Tests of the room beside the jaws, as the policy sees it: the expert's own measure, as seen."""

import numpy as np
import pytest
import torch
from torch import Tensor

from controller.diffusion.scene.jaw_sides import OFFS_M, free_side, lines_at_risk_m, rooms_m
from controller.diffusion.scene.places import Places, places_on
from controller.expert.approaches import Approach
from controller.expert.jaw_room import firm_room_m
from controller.expert.motion import FIRM_ROOM_M
from controller.expert.targets import clip_pose, clip_stations_m, opening_rad
from tests.planner.observations import clipped
from tissue_sim.frames import AWAY, inverse_pose, transform
from tissue_sim.outcome.predicates import applier_on
from tissue_sim.patient.anatomy import anatomy_from_seed
from tissue_sim.sensing.observation import fields
from tissue_sim.tools.arms import RIGHT_ARM
from tissue_sim.world import World

SEEDS = (8007, 8009, 8011)  # operable, the second with an artery beside the hepatic artery
AS_SEEN_M = 6e-4  # ten points instead of the mesh
FORWARD = torch.tensor([[0.0, 0.0, 1.0]])


@pytest.fixture(scope="module", params=SEEDS)
def world(request: pytest.FixtureRequest) -> World:
    world = World()
    world.reset(anatomy_from_seed(request.param))
    return world


def parts_of(world: World) -> dict[str, Tensor]:
    """Return the parts of the exact observation, with the right tool turned straight ahead."""
    now = fields(torch.from_numpy(world.observe().vector())[None].double())
    ahead = world.T_world_endoscope[:3, :3].T @ AWAY
    now["tips_endoscope"][:, RIGHT_ARM, :, 2] = torch.from_numpy(ahead)
    return now


@pytest.mark.parametrize("k", [0, 1])
def test_the_room_is_the_experts(world: World, k: int) -> None:
    now, tube = parts_of(world), world.anatomy.structure(("left", "right")[k])
    applier = applier_on(world, tube).name
    world.equip(applier)
    forward = now["tips_endoscope"][:, RIGHT_ARM, :, 2]
    rooms = rooms_m(places_on(now).on(k), forward, now["tube_radius_m"][:, k], lines_at_risk_m(now))
    first = 0 if len(clip_stations_m(world, tube)) == 3 else 2
    for off_m, room_m in zip(OFFS_M, rooms[0, first].tolist(), strict=True):
        T = clip_pose(world, tube, 1, Approach(off_centre_m=off_m))
        opening = opening_rad(world.tubes, tube, applier)
        assert room_m == pytest.approx(firm_room_m(world, T, applier, opening), abs=AS_SEEN_M)


def test_lines_at_risk_follow_the_structures(world: World) -> None:
    seen = lines_at_risk_m(parts_of(world))[0].numpy()
    for name, line in zip(("common bile duct", "hepatic artery"), np.split(seen, 2), strict=True):
        centres = transform(inverse_pose(world.T_world_endoscope), world.tubes.centres(name))
        away_m = np.linalg.norm(line[:, None] - centres, axis=-1).min(axis=1)
        assert away_m.max() < 0.003  # half the way between two rings


def beside_the_left_tube(across_m: float) -> tuple[Places, Tensor]:
    """Return the places on a straight tube, and a structure along it, this far across the jaws."""
    now = fields(torch.from_numpy(clipped().vector())[None])
    on_tube = places_on(now).on(0)
    across = torch.linalg.cross(FORWARD[0], on_tube.along[0, 0])
    line_m = on_tube.points_m[0, 0] + torch.linspace(-0.03, 0.03, 5)[:, None] * on_tube.along[0, 0]
    far_m = line_m + 1.0
    return on_tube, torch.cat([line_m + across_m * across, far_m])[None]


@pytest.mark.parametrize(("across_m", "side"), [(0.012, 0.0), (0.0068, -1.0), (-0.0068, 1.0)])
def test_the_jaws_go_away_from_what_is_beside_them(across_m: float, side: float) -> None:
    rooms = rooms_m(*placed(across_m))
    assert free_side(rooms - FIRM_ROOM_M)[0, 0].item() == side


def test_with_room_nowhere_they_go_where_there_is_most() -> None:
    rooms = rooms_m(*placed(0.0055))
    assert rooms.max() < FIRM_ROOM_M
    assert free_side(rooms - FIRM_ROOM_M)[0, 0].item() == -1.0


def placed(across_m: float) -> tuple[Places, Tensor, Tensor, Tensor]:
    on_tube, lines_m = beside_the_left_tube(across_m)
    return on_tube, FORWARD, torch.tensor([0.0015]), lines_m
