"""Tests of the choice of episodes: which are read, from several files and with their pictures."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from controller.dataset.choice import Choice
from controller.dataset.filmed import read_filmed
from controller.dataset.merge import merge
from controller.dataset.reader import read_episodes
from tests.controller.dataset.episodes import frame_of, write_parts

SEEDS = range(7)
KINDS = st.lists(st.sampled_from(["nominal:textbook", "recovery:grasp-slip", "nominal"]))


@given(kinds=KINDS, share=st.floats(0.01, 1.0), more=st.floats(0.01, 1.0))
def test_a_larger_share_has_all_of_a_smaller_one_and_no_kind_left_out(kinds, share, more):
    rows = [{"kind": kind} for kind in kinds]
    less, most = sorted((share, more))
    small, large = (Choice(share=s, leave_out=["recovery"]).of(rows) for s in (less, most))
    assert all(b for a, b in zip(small, large, strict=True) if a)
    assert not any(t for t, kind in zip(large, kinds, strict=True) if kind.startswith("recovery"))
    whole = Choice(share=less).of(rows)
    assert len(rows) * less <= sum(whole) < len(rows) * less + 1


@given(per_cent=st.integers(1, 100))
def test_a_share_in_per_cent_of_a_hundred_is_as_many(per_cent):
    rows = [{"kind": "nominal"}] * 100
    assert sum(Choice(share=per_cent / 100).of(rows)) == per_cent


@pytest.mark.parametrize("share", [0.0, -0.1, 1.1, float("nan")])
def test_a_share_out_of_range_is_refused(share):
    with pytest.raises(ValueError, match="share must be above 0 and at most 1"):
        Choice(share=share)


@pytest.mark.parametrize("file_most_mb", [100.0, 1e-3])
def test_the_first_share_is_read_from_one_file_or_several(tmp_path, file_most_mb):
    merge(write_parts(tmp_path / "parts", SEEDS), tmp_path, file_most_mb)
    whole = list(read_episodes(tmp_path))
    some = list(read_episodes(tmp_path, choice=Choice(share=0.5)))
    assert [e.header.seed for e in some] == [0, 1, 2, 3]
    for episode, same in zip(some, whole, strict=False):
        assert (episode.columns["action"] == same.columns["action"]).all()
    assert not list(read_episodes(tmp_path, choice=Choice(leave_out=["nominal"])))


def test_chosen_episodes_have_their_own_pictures(tmp_path):
    merge(write_parts(tmp_path / "parts", (3, 4), cameras=("endoscope_left",)), tmp_path)

    def shown(choice: Choice) -> list[list[int]]:
        read = read_filmed(tmp_path, ("action",), ("endoscope_left",), lambda p: p[:2, :3], choice)
        return [[frame_of(p[0]) for p in pictures] for _, pictures in read]

    whole = shown(Choice())
    some = shown(Choice(share=0.7))
    assert 0 < len(some) < len(whole)
    assert some == whole[: len(some)]
