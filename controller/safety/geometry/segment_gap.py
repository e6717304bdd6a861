"""Compute the gaps between the links' cores and line segments, in closed form, by a Warp kernel.

The squared distance to a box is convex along a segment. Its slope is piecewise linear, with bends
in the planes of the faces. The minimum lies between the bends, or ends, where the slope changes its
sign.
"""

from __future__ import annotations

from functools import cache
from threading import get_ident
from typing import Any

import warp as wp

from controller.safety.geometry.link_cores import N_LINK, LinkCores
from tissue_sim.frames import Array

wp.set_module_options({"enable_backward": False})

_N_CORE = 2 * N_LINK


@wp.func
def _on_box(point: wp.vec3d, half: wp.vec3d):
    return wp.max(wp.min(point, half), -half)


@wp.func
def _slope(start: wp.vec3d, way: wp.vec3d, half: wp.vec3d, share: wp.float64):
    """Return half the slope of the squared distance, at a share of the way."""
    point = start + share * way
    return wp.dot(point - _on_box(point, half), way)


@wp.func
def _nearest_share(start: wp.vec3d, way: wp.vec3d, half: wp.vec3d):
    """Return the share of a segment's way that is nearest to a box around the origin."""
    zero, one = wp.float64(0.0), wp.float64(1.0)
    low, high = zero, one
    for k in range(6):
        axis = k % 3
        if way[axis] != zero:
            face = wp.where(k < 3, half[axis], -half[axis])
            bend = wp.clamp((face - start[axis]) / way[axis], zero, one)
            if _slope(start, way, half, bend) < zero:
                low = wp.max(low, bend)
            else:
                high = wp.min(high, bend)
    falls = -_slope(start, way, half, low)
    rises = _slope(start, way, half, high)
    if falls <= zero:
        return low
    if rises <= zero:
        return high
    return low + (high - low) * falls / (falls + rises)


@wp.func
def _at_least(start: wp.vec3d, end: wp.vec3d, half: wp.vec3d):
    """Return the distance between the given box and the bounding box of the segment."""
    beyond = wp.max(wp.min(start, end), -wp.max(start, end)) - half
    return wp.length(wp.max(beyond, wp.vec3d()))


@wp.kernel(module="unique")
def _measure(
    centre: wp.array(dtype=wp.vec3d),
    R_world_core: wp.array(dtype=wp.mat33d),
    half_size: wp.array(dtype=wp.vec3d),
    start: wp.array(dtype=wp.vec3d),
    end: wp.array(dtype=wp.vec3d),
    within: wp.array2d(dtype=wp.float64),
    apart: wp.array2d(dtype=wp.float64),
    on_core: wp.array2d(dtype=wp.vec3d),
    on_segment: wp.array2d(dtype=wp.vec3d),
):
    core, segment = wp.tid()
    R, half = R_world_core[core], half_size[core]
    first = wp.transpose(R) * (start[segment] - centre[core])
    last = wp.transpose(R) * (end[segment] - centre[core])
    apart[core, segment] = wp.float64(wp.inf)
    if _at_least(first, last, half) < within[core, segment]:
        nearest = first + _nearest_share(first, last - first, half) * (last - first)
        on_box = _on_box(nearest, half)
        apart[core, segment] = wp.length(nearest - on_box)
        on_segment[core, segment] = centre[core] + R * nearest
        on_core[core, segment] = centre[core] + R * on_box


class _Workspace:
    """Arrays that numpy and Warp share, for a number of segments, and the launch over them."""

    def __init__(self, n_segment: int) -> None:
        def shared(shape: Any, dtype: Any) -> Any:
            return wp.zeros(shape, dtype=dtype, device="cpu")

        pairs = _N_CORE, n_segment
        inputs = [shared(_N_CORE, dtype) for dtype in (wp.vec3d, wp.mat33d, wp.vec3d)]
        inputs += [*(shared(n_segment, wp.vec3d) for _ in range(2)), shared(pairs, wp.float64)]
        outputs = [shared(pairs, dtype) for dtype in (wp.float64, wp.vec3d, wp.vec3d)]
        self.inputs, self.outputs = ([a.numpy() for a in arrays] for arrays in (inputs, outputs))
        self.launch = wp.launch(
            _measure, dim=pairs, inputs=inputs, outputs=outputs, device="cpu", record_cmd=True
        )


@cache
def _workspace(n_segment: int, thread: int) -> _Workspace:
    """Return a thread's own workspace, because another thread may launch while results are read."""
    return _Workspace(n_segment)


def segment_gaps(
    links: LinkCores, start_m: Array, end_m: Array, within_m: Array
) -> tuple[Array, Array, Array]:
    """Return the gaps between the links' cores and segments from start to end (n, 3), world frame.

    Args:
        links: The links of both instruments.
        start_m: (n, 3) starts of the segments.
        end_m: (n, 3) ends of the segments.
        within_m: (8, n) distances; pairs that are farther apart need no gap.

    Returns:
        (8, n) distances, infinite where there is no need. (8, n, 3) nearest points of the cores,
        and of the segments. The next call overwrites all three arrays.
    """
    work = _workspace(len(start_m), get_ident())
    values = links.centre_m, links.R_world_core, links.half_size_m, start_m, end_m, within_m
    for array, value in zip(work.inputs, values, strict=True):
        array[:] = value
    work.launch.launch()
    apart_m, on_core_m, on_segment_m = work.outputs
    return apart_m, on_core_m, on_segment_m
