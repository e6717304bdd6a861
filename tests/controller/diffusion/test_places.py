"""Tests of where clips and cut belong, as the policy sees it: the clip rule, on a drawn tube."""

import numpy as np
import pytest
import torch
from torch import Tensor

from controller.diffusion.scene.places import FINE_M, NUMBERS, place_features, places_on
from tests.tissue_sim.kinds import SLIM_APPLIER
from tissue_sim.frames import exponential
from tissue_sim.outcome.clip_rule import clip_stations_m, cut_room_m, needed_m, spacing_m
from tissue_sim.sensing.observation import MAX_CLIPS, TUBE_POINTS, VECTOR_SIZE, fields
from tissue_sim.tools.arms import RIGHT_ARM

LENGTH_M = 0.024  # at rest
STRETCH = 1.08  # by traction
FIRST = {3: 0, 2: 4}  # rows of the places for three clips, and for two


def seen(*clips_m: float, length_m: float = LENGTH_M) -> dict[str, Tensor]:
    """Return two drawn tubes, the left one the duct, with clips at stations of it."""
    now = fields(torch.zeros(1, VECTOR_SIZE))
    y = torch.linspace(0.0, STRETCH * length_m, TUBE_POINTS)
    for tube, x in enumerate((0.0, -0.012)):
        now["tubes_m"][0, tube] = torch.stack(
            [torch.full_like(y, x), y, torch.full_like(y, 0.09)], dim=1
        )
    now["sac_m"][0, 0] = now["tubes_m"][0, 0, -1]
    now["rest_length_m"][:] = length_m
    now["tips_endoscope"][0, :, :, :3] = torch.eye(3)
    for k, station_m in enumerate(clips_m):
        now["clips_m"][0, k] = torch.tensor([0.0, STRETCH * station_m, 0.09])
    now["n_clips"][:] = len(clips_m)
    return now


def features(now: dict[str, Tensor], side: int = 0) -> list[Tensor]:
    """Return the places on a tube, coarse, near and fine, and the spare lengths."""
    *places, spare = place_features(now, places_on(now))[:, side].split([27, 27, 27, 2], dim=1)
    return [*(part.unflatten(1, (9, 3)) for part in places), spare]


def places_m(now: dict[str, Tensor], side: int = 0) -> Tensor:
    """Return the places (n, 3) on a tube relative to the right tip, in the tool's frame."""
    coarse, *_ = features(now, side)
    return 0.03 * coarse[0]


@pytest.mark.parametrize(("side", "kind"), [(0, "duct"), (1, "artery")])
@pytest.mark.parametrize("n", NUMBERS)
def test_clips_and_cut_belong_where_the_rule_puts_them(side: int, kind: str, n: int) -> None:
    stations = [float(s) for s in clip_stations_m(kind, np.array(LENGTH_M), SLIM_APPLIER, n)]
    found = places_m(seen(), side)[FIRST[n] :][: n + 1, 1] / STRETCH
    cut_m = 0.5 * (stations[-2] + stations[-1])
    assert found.tolist() == pytest.approx([*stations, cut_m], abs=1e-6)


def test_a_clip_too_high_moves_the_next_one_up() -> None:
    low_m = float(clip_stations_m("duct", np.array(LENGTH_M), SLIM_APPLIER)[1])
    found = places_m(seen(low_m))[1, 1] / STRETCH
    assert float(found) == pytest.approx(low_m + spacing_m(SLIM_APPLIER), abs=1e-6)


def test_the_cut_belongs_in_the_widest_gap_above_the_clips_that_stay() -> None:
    found = places_m(seen(0.004, 0.009, 0.013, 0.019))[3, 1] / STRETCH
    assert float(found) == pytest.approx(0.016, abs=1e-6)


@pytest.mark.parametrize(("n", "row"), [(3, 7), (2, 8)])
def test_the_lowest_place_of_the_upper_clip_leaves_room_for_the_cut(n: int, row: int) -> None:
    low_m = float(clip_stations_m("duct", np.array(LENGTH_M), SLIM_APPLIER, n)[-2])
    sitting = [0.006, 0.0105][: n - 1]
    for clips_m, below_m in (((), low_m), (sitting, sitting[-1])):
        found = places_m(seen(*clips_m))[row, 1] / STRETCH
        assert float(found) == pytest.approx(below_m + cut_room_m(SLIM_APPLIER), abs=1e-6)


def test_places_do_not_depend_on_the_view() -> None:
    """Turn and move the scene and both tools together."""
    now, turned = seen(0.006, 0.011), seen(0.006, 0.011)
    R = torch.from_numpy(exponential(np.array([0.3, -0.8, 0.5]))).float()
    for name in ("tubes_m", "sac_m", "clips_m"):
        turned[name][:] = now[name] @ R.T + 0.02
    turned["tips_endoscope"][..., :3] = R
    turned["tips_endoscope"][..., 3] = 0.02
    for a, b in zip(features(now), features(turned), strict=True):
        torch.testing.assert_close(a, b, atol=2e-3, rtol=0.0)


def test_a_twentieth_of_a_millimetre_is_seen_at_the_place() -> None:
    """Check that a feature of order one changes by 0.03 or more."""
    now, moved = seen(), seen()
    at = places_m(now)[0]
    now["tips_endoscope"][:, RIGHT_ARM, :, 3] = at
    moved["tips_endoscope"][:, RIGHT_ARM, :, 3] = at + torch.tensor([0.0, 5e-5, 0.0])
    fine, other = features(now)[2], features(moved)[2]
    assert float((fine - other)[0, 0].abs().max()) == pytest.approx(5e-5 / FINE_M, rel=0.1)


@pytest.mark.parametrize("n", NUMBERS)
def test_what_is_spare_is_zero_on_a_tube_with_just_room(n: int) -> None:
    spare = features(seen(length_m=needed_m("duct", SLIM_APPLIER, n)))[3]
    assert float(spare[0, NUMBERS.index(n)]) == pytest.approx(0.0, abs=1e-3)


def test_no_clip_and_no_tube_break_nothing() -> None:
    now = fields(torch.zeros(1, VECTOR_SIZE))
    assert all(part.isfinite().all() for part in features(now))
    assert now["clips_m"].shape[1] == MAX_CLIPS
