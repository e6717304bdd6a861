"""Tests of restoring: a broken state is refused in one line, and the world does not change."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.tissue_sim.treatment import TUBE, assert_same, clip_and_cut, run
from tissue_sim.mechanics.layout import LINK_CAPACITY, N_SHAPES
from tissue_sim.patient.mesher import signed_volumes
from tissue_sim.patient.textbook import textbook_from_seed
from tissue_sim.state_check import require_type
from tissue_sim.surgery.record import Record
from tissue_sim.world import World
from tissue_sim.world_state import copied

SEED = 10_005


@pytest.fixture(scope="module")
def treated(one_world: World) -> World:
    """Return a world with tools at the tissue, a clip and a cut; no test changes it."""
    one_world.reset(textbook_from_seed(SEED))
    run(one_world, 0, 40)
    clip_and_cut(one_world)
    return one_world


@pytest.fixture(scope="module")
def saved(treated: World) -> dict[str, Any]:
    return treated.state()


def parts(node: Any, path: tuple = ()) -> Iterator[tuple[tuple, Any]]:
    """Yield path and value of every part of a state, down to its arrays."""
    named = node.items() if isinstance(node, dict) else enumerate(node)
    for name, part in named:
        yield (*path, name), part
        if isinstance(part, dict | tuple):
            yield from parts(part, (*path, name))


def with_value(node: Any, path: tuple, value: Any) -> Any:
    """Return a copy with another value at a path; `DELETED` removes the part."""
    name, *rest = path
    new = with_value(node[name], tuple(rest), value) if rest else value
    if isinstance(node, tuple):
        return tuple(part if k != name else new for k, part in enumerate(node))
    kept = {k: part for k, part in node.items() if k != name}
    return kept if new is DELETED else kept | {name: new}


DELETED = object()


def assert_refused(world: World, state: Any, *words: object) -> None:
    before, tissue = world.state(), world.tissue
    with pytest.raises(ValueError) as caught:  # noqa: PT011  the message is checked below
        world.restore(state)
    line = str(caught.value)
    assert "\n" not in line
    assert len(line) < 200
    assert all(str(word) in line for word in words), line
    assert world.tissue is tissue
    assert_same(world.state(), before)


def test_every_part_is_required(treated: World, saved: dict[str, Any]) -> None:
    for path, _ in parts(saved):
        if isinstance(path[-1], str):
            assert_refused(treated, with_value(saved, path, DELETED), path[-1])


def test_no_other_part_is_allowed(treated: World, saved: dict[str, Any]) -> None:
    for path, part in [((), saved), *parts(saved)]:
        if isinstance(part, dict):
            other = with_value(saved, path, part | {"bile": 1}) if path else part | {"bile": 1}
            assert_refused(treated, other, "bile")


SPOILED = {
    "None": lambda part: None,
    "list": lambda part: part.tolist() if isinstance(part, np.ndarray) else [part],
    "shape": lambda part: np.asarray(part)[None],
    "shorter": lambda part: part[:-1] if isinstance(part, np.ndarray | tuple) and len(part) else 0,
    "type": lambda part: part.astype(complex) if isinstance(part, np.ndarray) else 0.5,
}


@pytest.mark.parametrize("spoil", SPOILED.values(), ids=SPOILED)
def test_every_part_must_have_its_type_and_shape(
    treated: World, saved: dict[str, Any], spoil
) -> None:
    for path, part in parts(saved):
        if not isinstance(part, dict | Record):
            assert_refused(treated, with_value(saved, path, spoil(part)), path[0])


@pytest.mark.parametrize("state", [None, 3, "state", [], {}, ({},)], ids=repr)
def test_an_object_that_is_not_a_state_is_refused(treated: World, state: Any) -> None:
    assert_refused(treated, state)


@given(data=st.data(), bad=st.sampled_from([np.nan, np.inf, -np.inf]))
def test_a_state_with_one_number_that_is_not_finite_is_refused(
    treated: World, saved: dict[str, Any], data: st.DataObject, bad: float
) -> None:
    numbers = [p for p, a in parts(saved) if isinstance(a, np.ndarray) and a.dtype.kind == "f"]
    path = data.draw(st.sampled_from(numbers))
    array = dict(parts(saved))[path].copy()
    array.flat[data.draw(st.integers(0, array.size - 1))] = bad
    assert_refused(treated, with_value(saved, path, array), *path, "finite")


def spare(world: World) -> int:
    """Return the first vertex that is not in use."""
    return world.tissue.n_vertex()


OUT_OF_RANGE = {
    "tet": (("tissue", "tet"), spare),
    "negative tet": (("tissue", "tet"), -1),
    "link": (("tissue", "link"), spare),
    "ring above a cut": (("tissue", "ring_above"), spare),
    "ring's upper side": (("above", TUBE), spare),
    "shape": (("tissue", "contact_shape"), N_SHAPES),
    "alive": (("tissue", "tet_alive"), 2),
    "vertices": (("tissue", "n_vertex"), 2**30),
    "parts": (("tissue", "n_part"), 2**30),
    "part": (("tissue", "part"), lambda world: int(world.tissue.host("n_part")[0])),
    "no vertices": (("tissue", "n_vertex"), 0),
    "mass": (("tissue", "mass"), -1.0),
    "tie": (("tissue", "tie_stiffness"), -1.0),
    "strand": (("tissue", "link_strength"), -1.0),
    "station": (("stations", TUBE), 1.0),
    "joint": (("arms", "qpos"), 3.0),
    "target": (("arms", "drive_targets"), -3.0),
}


@pytest.mark.parametrize(("path", "value"), OUT_OF_RANGE.values(), ids=OUT_OF_RANGE)
def test_numbers_out_of_range_are_refused(
    treated: World, saved: dict[str, Any], path: tuple, value: Any
) -> None:
    array = saved[path[0]][path[1]].copy()
    array.flat[array.size // 3] = value(treated) if callable(value) else value
    assert_refused(treated, with_value(saved, path, array), "/".join(path), "to")


def test_elements_of_another_mesh_are_refused(treated: World, saved: dict[str, Any]) -> None:
    tet = saved["tissue"]["tet"].copy()
    tet[0, [3, 300]] = tet[0, [300, 3]]
    assert_refused(treated, with_value(saved, ("tissue", "tet"), tet), "volume[0, 3]")


def test_a_topology_too_large_for_the_matrix_is_refused(
    treated: World, saved: dict[str, Any]
) -> None:
    """Use elements across the whole body: they couple more vertices than neighbours do."""
    tissue = saved["tissue"]
    tet, volume = tissue["tet"].copy(), tissue["volume"].copy()
    rng = np.random.default_rng(0)
    tet[0] = [rng.choice(spare(treated), 4, replace=False) for _ in tet[0]]
    volume[0] = signed_volumes(tissue["rest"][0].astype(float), tet[0])
    assert_refused(treated, saved | {"tissue": tissue | {"tet": tet, "volume": volume}}, "capacity")


def test_both_right_tools_cannot_be_mounted(treated: World, saved: dict[str, Any]) -> None:
    for mounted in ([True, True, True], [True, False, False], [False, True, False]):
        assert_refused(
            treated, with_value(saved, ("arms", "mounted"), np.array(mounted)), "mounted"
        )


def test_a_load_without_a_pull_is_refused(treated: World, saved: dict[str, Any]) -> None:
    load = np.ones_like(saved["tissue"]["load"])
    assert_refused(treated, with_value(saved, ("tissue", "load"), load), "no pull")


def spoiled_records(record: Record) -> dict[str, Any]:
    clip, cut = record.clips[-1], record.cuts[-1]
    crossing = clip.crossings[0]
    bare = object.__new__(Record)
    return {
        "None": None,
        "no record": {"clips": ()},
        "type": Record,
        "empty": bare,
        "time": replace(record, time_s=np.nan),
        "no time": replace(record, time_s="late"),
        "list": replace(record, clips=[clip]),
        "no clip": replace(record, clips=(cut,)),
        "vertex": replace(record, clips=(replace(clip, vertices=(10**6,)),)),
        "negative vertex": replace(record, clips=(replace(clip, vertices=(-1,)),)),
        "link": replace(record, clips=(replace(clip, links=(LINK_CAPACITY,)),)),
        "kind": replace(record, clips=(replace(clip, kind=replace(clip.kind, width_m=0.002)),)),
        "complete": replace(record, clips=(replace(clip, complete=()),)),
        "pose": replace(record, clips=(replace(clip, T_world_clip=np.eye(3)),)),
        "pose of objects": replace(record, clips=(replace(clip, T_world_clip=np.array([None])),)),
        "tube": replace(
            record, clips=(replace(clip, crossings=(replace(crossing, tube="vein"),)),)
        ),
        "ring": replace(record, cuts=(replace(cut, ring=999),)),
        "grasp": replace(record, grasp=replace(record.grasp, vertices=(1, 2), place_tool_m=())),
        "place": replace(
            record, grasp=replace(record.grasp, vertices=(1,), place_tool_m=((0.0, 0.0),))
        ),
        "limits": replace(record, broken_limits=frozenset([3])),
    }


def test_an_impossible_record_is_refused(treated: World, saved: dict[str, Any]) -> None:
    for spoiled in spoiled_records(treated.record).values():
        assert_refused(treated, saved | {"record": spoiled}, "state/record")


def test_a_refusal_does_not_change_later_steps(
    treated: World, saved: dict[str, Any], one_world: World
) -> None:
    once = run(one_world, 40, 60)
    one_world.restore(saved)
    observation = one_world.observe().vector()
    for name in ("tissue", "arms", "record"):
        with pytest.raises(ValueError, match=name):
            one_world.restore(with_value(saved, (name,), DELETED))
    np.testing.assert_array_equal(one_world.observe().vector(), observation)
    assert_same(run(one_world, 40, 60), once)
    one_world.restore(saved)


def test_a_state_after_a_cut_can_be_restored_in_a_new_world_and_back(
    treated: World, saved: dict[str, Any]
) -> None:
    fresh = World()
    fresh.reset(treated.anatomy)
    begun = fresh.state()
    fresh.restore(saved)
    assert_same(fresh.state(), saved)
    treated.restore(begun)
    assert_same(treated.state(), begun)
    treated.restore(fresh.state())
    assert_same(treated.state(), saved)


def test_a_restored_world_shares_nothing_with_the_state(
    treated: World, saved: dict[str, Any]
) -> None:
    given_away = copied(saved)
    treated.restore(given_away)
    for _, part in parts(given_away):
        if isinstance(part, np.ndarray):
            part[...] = 0
    assert_same(treated.state(), saved)


@given(joints=st.lists(st.floats(-1, 1), min_size=14, max_size=14))
def test_types_are_checked_in_depth(joints: list[float]) -> None:
    """Check tuples of a fixed length and of any length, and unions."""
    require_type(tuple(joints), tuple[float, ...], "x")
    require_type(None, float | None, "x")
    for wrong, kind in (
        (tuple(joints), tuple[float, float]),
        ((*joints, "a"), tuple[float, ...]),
        ("a", float | None),
        (joints, tuple[float, ...]),
    ):
        with pytest.raises(ValueError, match="x"):
            require_type(wrong, kind, "x")
