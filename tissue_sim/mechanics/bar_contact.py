"""Compute contact of the rigid bars that tissue carries (closed clips).

Bars touch instruments and other bars. A bar is a row of balls on an axis. The vertices that carry
the bar define its middle and axis, as weighted sums of their positions. A ball's position is
therefore also a weighted sum. The same weights divide the ball's force among the vertices, so force
and torque stay balanced. Contact is a linear penalty without friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import warp as wp

from tissue_sim.frames import Array
from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes
from tissue_sim.mechanics.touch import add_vertex_term, along_segment, link_origin, touch

wp.set_module_options({"enable_backward": False})

BALLS = 5  # balls of a bar: they overlap, so that no edge passes between two of them
N_BARS, BAR_VERTICES = 16, 64  # capacities: bars of one environment, vertices of one bar
BALL_COUNT = wp.constant(BALLS)
BAR_STIFFNESS = wp.constant(1000.0)  # N/m per ball, assumed: stiffer than the tubes beside it
FIRST_RIGHT_SHAPE = wp.constant(4)


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A rigid bar that tissue carries.

    Attributes:
        vertices: The vertices that carry the bar.
        middle: (n,) weights of the vertices' positions in the bar's middle; their sum is 1.
        axis: (n,) weights, 1/m, of the vertices' positions in the bar's direction; their sum is 0.
        reach_m: Distance from the bar's middle to the first and last ball's centre.
        radius_m: Radius of the balls.
        in_jaws: Whether the jaws of the right instrument hold the bar; such jaws do not push it.
    """

    vertices: Sequence[int]
    middle: Array
    axis: Array
    reach_m: float
    radius_m: float
    in_jaws: bool


@wp.func
def carried(
    t: TissueArrays, weight: wp.array(dtype=float), x: wp.array(dtype=wp.vec3), b: int, k: int
):
    """Return the weighted sum of the positions x of the vertices that carry bar k."""
    p = wp.vec3()
    for m in range(t.bar_count[b, k]):
        p = p + x[t.bar_vertex[b, k, m]] * weight[m]
    return p


@wp.func
def ball_offset(t: TissueArrays, b: int, k: int, j: int):
    """Return the place of ball j along the bar, from the bar's middle, m."""
    return t.bar_reach[b, k] * (2.0 * float(j) / float(BALL_COUNT - 1) - 1.0)


@wp.func
def place_bar(t: TissueArrays, b: int, k: int):
    """Find the balls of a bar now and at the start of the step, and clear their contacts."""
    middle = t.bar_middle[b, k]
    axis = t.bar_axis[b, k]
    now = carried(t, middle, t.position[b], b, k)
    before = carried(t, middle, t.previous[b], b, k)
    along = carried(t, axis, t.position[b], b, k)
    along_before = carried(t, axis, t.previous[b], b, k)
    length = wp.length(along) + 1.0e-9
    t.bar_scale[b, k] = 1.0 / length
    t.bar_force[b, k] = wp.vec3()
    for j in range(BALL_COUNT):
        offset = ball_offset(t, b, k, j)
        t.ball[b, k, j] = now + along * (offset / length)
        t.ball_before[b, k, j] = before + wp.normalize(along_before) * offset
        t.ball_shape[b, k, j] = -1


@wp.func
def ball_weight(t: TissueArrays, b: int, k: int, m: int, offset: float):
    """Return the share of vertex m in the motion of a ball at this place along bar k."""
    return t.bar_middle[b, k, m] + offset * t.bar_axis[b, k, m] * t.bar_scale[b, k]


@wp.func
def load_bar(t: TissueArrays, b: int, k: int, offset: float, f: wp.vec3, K: wp.mat33):
    """Add a force at a place along a bar, and its stiffness, to the vertices that carry the bar.

    The matrix pattern has no place for the coupling of all vertices. Each vertex gets the sum of
    its row.
    """
    total = float(0.0)
    for m in range(t.bar_count[b, k]):
        total = total + wp.abs(ball_weight(t, b, k, m, offset))
    for m in range(t.bar_count[b, k]):
        w = ball_weight(t, b, k, m, offset)
        add_vertex_term(t, b, t.bar_vertex[b, k, m], f * w, K * (wp.abs(w) * total))


@wp.func
def push_from_tools(t: TissueArrays, s: ToolShapes, b: int, k: int, j: int):
    """Push a ball out of the instrument with the deepest penetration.

    A contact that exists at the start of the step lasts to its end, as on the liver bed. Jaws that
    have just closed the clip do not push it.
    """
    x = t.ball[b, k, j]
    before = t.ball_before[b, k, j]
    radius = t.bar_radius[b, k]
    n_shape = s.radius.shape[1]
    if t.bar_in_jaws[b, k] != 0:
        n_shape = FIRST_RIGHT_SHAPE
    deepest = float(-1.0e9)
    normal = wp.vec3()
    for c in range(n_shape):
        hit = touch(s, b, c, x, before, 0.0)
        depth = hit.depth + radius
        stands = depth > 0.0 or touch(s, b, c, before, before, 0.0).depth + radius > 0.0
        if stands and depth > deepest:
            deepest = depth
            normal = hit.normal
            t.ball_shape[b, k, j] = c
    if t.ball_shape[b, k, j] >= 0:
        f = normal * (BAR_STIFFNESS * deepest)
        K = wp.outer(normal, normal) * BAR_STIFFNESS
        t.ball_force[b, k, j] = f
        t.ball_stiffness[b, k, j] = K
        load_bar(t, b, k, ball_offset(t, b, k, j), f, K)


@wp.func
def push_from_bar(t: TissueArrays, b: int, k: int, j: int, other: int):
    """Push ball j of bar k and another bar apart."""
    reach = t.bar_reach[b, other]
    start = t.ball[b, other, 0]
    u = t.ball[b, other, BALL_COUNT - 1] - start
    start_before = t.ball_before[b, other, 0]
    u_before = t.ball_before[b, other, BALL_COUNT - 1] - start_before
    p = t.ball[b, k, j] - start
    p_before = t.ball_before[b, k, j] - start_before
    share = along_segment(p, u)
    q = p - u * share
    distance = wp.length(q)
    before = wp.length(p_before - u_before * along_segment(p_before, u_before))
    touching = t.bar_radius[b, k] + t.bar_radius[b, other]
    depth = touching - distance
    if depth > 0.0 or before < touching:
        n = q / (distance + 1.0e-9)
        f = n * (BAR_STIFFNESS * depth)
        # twice the diagonal, as between tubes
        K = wp.outer(n, n) * (2.0 * BAR_STIFFNESS)
        load_bar(t, b, k, ball_offset(t, b, k, j), f, K)
        load_bar(t, b, other, reach * (2.0 * share - 1.0), -f, K)
        wp.atomic_add(t.bar_force, b, k, f)
        wp.atomic_sub(t.bar_force, b, other, f)


@wp.func
def push_bar(t: TissueArrays, s: ToolShapes, b: int, k: int):
    """Push a bar out of the instruments and out of the earlier bars."""
    for j in range(BALL_COUNT):
        push_from_tools(t, s, b, k, j)
        for other in range(k):
            push_from_bar(t, b, k, j, other)


@wp.func
def react_to_bar(t: TissueArrays, s: ToolShapes, b: int, k: int):
    """Add the reaction of a bar's balls to the shapes that they touch.

    The reaction is opposite to the sum of the forces on the vertices, at the solution of the step.
    """
    for j in range(BALL_COUNT):
        c = t.ball_shape[b, k, j]
        if c >= 0:
            offset = ball_offset(t, b, k, j)
            total = float(0.0)
            moved = wp.vec3()
            for m in range(t.bar_count[b, k]):
                w = wp.abs(ball_weight(t, b, k, m, offset))
                total = total + w
                moved = moved + t.step[b, t.bar_vertex[b, k, m]] * w
            f = t.ball_force[b, k, j] - t.ball_stiffness[b, k, j] * moved * total
            t.ball_force[b, k, j] = f
            wp.atomic_add(t.bar_force, b, k, f)
            arm = t.ball[b, k, j] - link_origin(s.T_world_link[b, c])
            wp.atomic_sub(s.force, b, c, f)
            wp.atomic_sub(s.torque, b, c, wp.cross(arm, f))


@wp.func
def add_bar_contact(t: TissueArrays, s: ToolShapes, b: int):
    """Add the contact of every bar with the instruments and with the other bars."""
    for k in range(t.n_bar[b]):
        place_bar(t, b, k)
    for k in range(t.n_bar[b]):
        push_bar(t, s, b, k)


@wp.func
def react_to_bars(t: TissueArrays, s: ToolShapes, b: int):
    for k in range(t.n_bar[b]):
        react_to_bar(t, s, b, k)
