"""Tests of how thick the gallbladder is, as the policy sees it."""

import pytest
import torch

from controller.diffusion.scene.gallbladder import (
    HIGH,
    ROOM_M,
    gallbladder_features,
    wall_distance_m,
)
from controller.diffusion.scene.places import places_on
from tests.planner.observations import clipped
from tissue_sim.patient.tube_names import TUBES
from tissue_sim.sensing.observation import fields

AXIS_M = torch.tensor([[[0.0, 0.0, 0.01 * k] for k in range(5)]])
CONE_M = torch.tensor([[0.004, 0.006, 0.008, 0.010, 0.012]])


@pytest.mark.parametrize(
    ("point_m", "distance_m"),
    [
        ((0.010, 0.0, 0.020), 0.002),
        ((0.0, 0.010, 0.015), 0.003),
        ((0.0, 0.0, 0.0), -0.004),
        ((0.0, 0.0, -0.010), 0.006),  # beyond the end the wall is round
    ],
)
def test_the_wall_is_as_far_from_the_axis_as_its_radius(
    point_m: tuple[float, ...], distance_m: float
) -> None:
    found = wall_distance_m(AXIS_M, CONE_M, torch.tensor([[point_m]]))
    assert found[0, 0].item() == pytest.approx(distance_m, abs=1e-7)


@pytest.mark.parametrize("n_tubes", [2, 3])
def test_a_thicker_gallbladder_leaves_less_room_at_the_upper_clips(n_tubes: int) -> None:
    """Check each of the tubes that are there; a tube that is not there has no room."""
    now = fields(torch.from_numpy(clipped().vector())[None].clone())
    if n_tubes == 3:
        now["third_tube"][:] = 1.0
        now["tubes_m"][:, 2] = now["tubes_m"][:, 1] - torch.tensor([0.004, 0.0, 0.0])
        now["rest_length_m"][:, 2] = now["rest_length_m"][:, 1]
    now["sac_radius_m"][:] = 0.004
    places = places_on(now)
    thin_radii, thin = gallbladder_features(now, places)
    now["sac_radius_m"] += 0.001
    thick_radii, thick = gallbladder_features(now, places)
    assert (thick_radii > thin_radii).all()
    less_m = ROOM_M * (torch.atanh(thin) - torch.atanh(thick))
    there = torch.arange(len(TUBES)).repeat_interleave(len(HIGH)) < n_tubes
    torch.testing.assert_close(less_m, 0.001 * there[None], atol=1e-5, rtol=0.0)
