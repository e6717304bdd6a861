"""Check a saved state of the world: one table of bounds, and rules between its parts.

The world defines the required parts and their types and shapes, and requires finite values. Only
tighter bounds need a line in the table.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tissue_sim.frames import Array
from tissue_sim.mechanics.layout import LINK_CAPACITY, N_SHAPES
from tissue_sim.mechanics.tissue import Tissue
from tissue_sim.patient.mesher import signed_volumes
from tissue_sim.patient.tubes import Tubes
from tissue_sim.state_check import Bound, brief, require_like, require_within
from tissue_sim.surgery.leak import HOLE, SIDES
from tissue_sim.surgery.record import Record
from tissue_sim.tools.clips import CLIPS

# Assumed: how far a joint may be pushed beyond its limit (rad; insertion m). Under random commands,
# arms that press on each other reached 0.05, single fingers 0.47.
BEYOND_LIMIT = np.array([0.2, 0.2, 0.02, 0.2, 0.2, 0.2, 1.5, 1.5])
FLAG = Bound(low=0, high=1)
POSITIVE = Bound(low=0)


def copied(node: Any) -> Any:
    """Copy every array; records are frozen and remain shared."""
    if isinstance(node, dict):
        return {name: copied(part) for name, part in node.items()}
    if isinstance(node, tuple):
        return tuple(copied(part) for part in node)
    return node.copy() if isinstance(node, np.ndarray) else node


def require_state(
    state: Any, example: dict[str, Any], tissue: Tissue, tubes: Tubes, joint_ranges: Array
) -> None:
    """Check a whole state of a world.

    Args:
        state: any object.
        example: a state of that world.
        tissue: the tissue of that world.
        tubes: the tubes of that world.
        joint_ranges: `Arms.joint_ranges`.

    Raises:
        ValueError: the world cannot have this state; the message says where and why.
    """
    if not isinstance(state, dict):
        raise ValueError(f"state: it is a {type(state).__name__}; expected: dict")
    for name in ("version", "anatomy"):
        given, own = state.get(name), example[name]
        if type(given) is not type(own) or given != own:
            raise ValueError(f"state: {name} is {brief(given)}, this world's is {own!r}")
    require_like(state, example, "state")
    require_within(state, _sizes(tissue), "state")
    require_within(state, _bounds(state, tubes, joint_ranges), "state")
    _require_mounted(state["arms"]["mounted"])
    _require_topology(state["tissue"], tissue)
    _require_history(state["record"], tubes)
    if state["record"].pull is None and state["tissue"]["load"].any():
        raise ValueError("state/tissue/load: it is not 0; expected: 0, as the record has no pull")


def _sizes(tissue: Tissue) -> dict[str, Bound]:
    """Return the bounds of the sizes that limit all other parts."""
    fewest, most = len(tissue.organs[0].vertices), tissue.host("position").shape[1]
    return {
        "tissue/n_vertex": Bound(low=fewest, high=most),
        "tissue/n_part": Bound(low=0, high=tissue.host("factor_first").shape[1]),
    }


def _bounds(state: dict[str, Any], tubes: Tubes, joint_ranges: Array) -> dict[str, Bound]:
    """Return bounds by pattern of a path in the state."""
    names = tubes.organ.hollow
    vertex = Bound(low=0, high=int(state["tissue"]["n_vertex"][0]) - 1)
    joints = Bound(
        low=joint_ranges[..., 0] - BEYOND_LIMIT, high=joint_ranges[..., 1] + BEYOND_LIMIT
    )
    return {
        "tissue/tet": vertex,
        "tissue/link": vertex,
        "tissue/ring_above": vertex,
        "tissue/part": Bound(low=-1, high=int(state["tissue"]["n_part"][0]) - 1),
        "tissue/tet_alive": FLAG,
        "tissue/folded": FLAG,
        "tissue/mu": POSITIVE,
        "tissue/lam": POSITIVE,
        "tissue/stiffness_holds": FLAG,
        "tissue/surface": FLAG,
        "tissue/covered": POSITIVE,
        "tissue/clamped": FLAG,
        "tissue/contact_shape": Bound(low=-1, high=N_SHAPES - 1),
        "tissue/strand_shape": Bound(low=-1, high=N_SHAPES - 1),
        "tissue/mass": POSITIVE,
        "tissue/*_stiffness": POSITIVE,
        "tissue/link_*": POSITIVE,
        "above/*": vertex,
        **{f"stations/{tube}": Bound(low=0, high=tubes.stations_m[tube][-1]) for tube in names},
        "arms/qpos": joints,
        "arms/drive_targets": joints,
        "record/*/vertices": vertex,
        "record/*/force_world_n": Bound(shape=(3,)),
        "record/*/sac_rings": Bound(low=0, high=len(tubes.organ.sac_rings) - 1),
        "record/*/links": Bound(low=0, high=LINK_CAPACITY - 1),
        "record/*/tube": Bound(names=names),
        "record/*/structure": Bound(names=(*names, "gallbladder")),
        "record/*/side": Bound(names=(*SIDES, HOLE)),
        "record/*/point_m": Bound(shape=(3,)),
        "record/*/place_m": Bound(shape=(3,)),
        "record/*/volume_m3": POSITIVE,
        "record/*/T_world_clip": Bound(shape=(4, 4)),
        "record/grasp/place_tool_m/*": Bound(shape=(3,)),
    }


def _require_mounted(mounted: NDArray[np.bool_]) -> None:
    """Check that the left arm's tool and one of the right arm's tools are mounted."""
    if not mounted[0] or mounted[1:].sum() != 1:
        raise ValueError(f"state/arms/mounted: it is {mounted}; expected: the first and one more")


def _require_topology(state: dict[str, Any], tissue: Tissue) -> None:
    """Check that the elements are those of the rest shape and that their matrix matches."""
    n, tets = int(state["n_vertex"][0]), state["tet"][0, : len(tissue.tets())]
    alive = state["tet_alive"][0, : len(tets)] != 0
    volume = state["volume"][0, : len(tets)]
    own = np.isclose(volume, signed_volumes(state["rest"][0].astype(float), tets), atol=0.0)
    for k in np.flatnonzero(alive & ~own)[:1]:
        raise ValueError(f"state/tissue/volume[0, {k}]: it is not that of the element's corners")
    tissue.pattern(0, n, tets, state["link"][0])


def _require_history(record: Record, tubes: Tubes) -> None:
    """Check that clips, cuts and the grasp match the tubes, and that paired entries agree."""
    crossings = [crossing for clip in record.clips for crossing in clip.crossings]
    for place in (*crossings, *record.openings):
        n_ring = len(tubes.below[place.tube])
        if not 0 <= place.ring < n_ring:
            raise ValueError(f"state/record: ring {place.ring} of the {place.tube} of {n_ring}")
    for clip in record.clips:
        if clip.kind != CLIPS.get(clip.kind.name):
            kind = clip.kind.name
            raise ValueError(f"state/record: clip {clip.number} is no {kind} clip of `CLIPS`")
        if clip.places_m.shape != (len(clip.vertices), 3):
            raise ValueError(f"state/record: clip {clip.number} has places {clip.places_m.shape}")
        for place, rings in zip(clip.crossings, clip.rings, strict=False):
            if not all(0 <= ring < len(tubes.below[place.tube]) for ring in rings):
                raise ValueError(f"state/record: clip {clip.number} is on rings {rings}")
    if record.pull is not None and not 1 <= record.pull.number <= len(record.clips):
        raise ValueError(f"state/record: a pull at clip {record.pull.number}, which is not there")
    pairs = [(c.crossings, other) for c in record.clips for other in (c.complete, c.rings)]
    for one, other in (*pairs, (record.grasp.vertices, record.grasp.place_tool_m)):
        if len(one) != len(other):
            raise ValueError(f"state/record: {len(one)} and {len(other)} of what goes in pairs")
