"""Keep a tube on one side of a tool's jaws: its corners vote on where it lies.

Contact stores a side for each vertex that touches a finger: +1 between the jaws, -1 outside. A
connected piece of a tube is at one of three places: outside the upper finger, between the fingers,
or outside the lower finger. Corners that a fast finger passed would otherwise stay at another
place, and the finger would pierce the tube. A piece with one ring outside either finger would be
wedged between the fingers for good.

The gallbladder's neck is as narrow as a finger, and votes as the upper end of the duct. A branch
is where its joint to the trunk is, because a finger does not pass through a joint.
"""

from __future__ import annotations

import warp as wp

from tissue_sim.mechanics.arrays import TissueArrays, ToolShapes

wp.set_module_options({"enable_backward": False})

UPPER = wp.constant(0)  # places of a piece, in the order of its votes
BETWEEN = wp.constant(1)
LOWER = wp.constant(2)
REACH = wp.constant(0.006)  # m; the largest distance of a contact from a patch
DECIDES = wp.constant(1000.0)  # weight of a joint's vote: more than a tube has corners


@wp.func
def to_link_frame(T_world_link: wp.mat44, x: wp.vec3):
    """Transform a world point to the link's frame."""
    R = wp.mat33(
        T_world_link[0, 0], T_world_link[0, 1], T_world_link[0, 2],
        T_world_link[1, 0], T_world_link[1, 1], T_world_link[1, 2],
        T_world_link[2, 0], T_world_link[2, 1], T_world_link[2, 2],
    )  # fmt: skip
    return wp.transpose(R) * (x - link_origin(T_world_link))


@wp.func
def link_origin(T_world_link: wp.mat44):
    return wp.vec3(T_world_link[0, 3], T_world_link[1, 3], T_world_link[2, 3])


@wp.func
def n_sections(t: TissueArrays, b: int, tube: int):
    """Return the number of sections of a tube; those of the first tube end with the neck's."""
    n = t.n_ring[b, tube]
    if tube == 0:
        n = n + t.neck.shape[1]
    return 2 * n


@wp.func
def n_corners(t: TissueArrays, b: int, tube: int, section: int):
    """Return the number of corners of a section."""
    if section < 2 * t.n_ring[b, tube]:
        return t.ring.shape[3]
    return t.neck.shape[2]


@wp.func
def corner(t: TissueArrays, b: int, tube: int, section: int, k: int):
    """Return vertex k of a tube's section.

    Section 2 r is the lower side of ring r, section 2 r + 1 is its upper side.
    """
    r = section / 2
    if r >= t.n_ring[b, tube]:
        return t.neck[b, r - t.n_ring[b, tube], k]
    if section % 2 == 0:
        return t.ring[b, tube, r, k]
    return t.ring_above[b, tube, r, k]


@wp.func
def is_severed(t: TissueArrays, b: int, tube: int, r: int):
    """Return whether the two sides of a ring share no corner."""
    shared = int(0)
    for k in range(t.ring.shape[3]):
        if t.ring_above[b, tube, r, k] == t.ring[b, tube, r, k]:
            shared = shared + 1
    return shared == 0


@wp.func
def votes(t: TissueArrays, b: int, i: int, upper: int):
    """Return vertex i's vote for each place; zeros if its side of no finger is known.

    The fingers are the shapes `upper` and `upper` + 1.
    """
    vote = wp.vec3()
    finger = t.contact_shape[b, i] - upper
    side = t.contact_side[b, i]
    if (finger == 0 or finger == 1) and side != 0.0:
        if side > 0.0:
            vote[BETWEEN] = 1.0
        else:
            vote[2 * finger] = 1.0
    return vote


@wp.func
def section_votes(t: TissueArrays, b: int, tube: int, section: int, upper: int):
    total = wp.vec3()
    for k in range(n_corners(t, b, tube, section)):
        total = total + votes(t, b, corner(t, b, tube, section, k), upper)
    return total


@wp.func
def side_now(s: ToolShapes, b: int, c: int, x: wp.vec3):
    """Return the side of finger c on which point x lies; 0 if x is not beside the finger's pad."""
    u = s.b[b, c] - s.a[b, c]
    w = s.half_width[b, c]
    p = x - s.a[b, c]
    along = wp.dot(p, u) / (wp.dot(u, u) + 1.0e-12)
    across = wp.dot(p, w) / (wp.dot(w, w) + 1.0e-12)
    height = wp.dot(p, wp.normalize(wp.cross(u, w)))
    if c % 4 == 2:
        height = -height
    beside = along > 0.0 and along < 1.0 and wp.abs(across) < 1.0 and wp.abs(height) < REACH
    return wp.where(beside, wp.sign(height), 0.0)


@wp.func
def joint_votes(t: TissueArrays, s: ToolShapes, b: int, tube: int, upper: int):
    """Return the votes of the corners that a trunk holds; no finger touches them."""
    total = wp.vec3()
    for k in range(t.ring.shape[3]):
        i = t.ring[b, tube, 0, k]
        if t.surface[b, i] + t.covered[b, i] + t.fixed[b, i] == 0:
            first = side_now(s, b, upper, t.position[b, i])
            second = side_now(s, b, upper + 1, t.position[b, i])
            if first < 0.0:
                total[UPPER] = total[UPPER] + DECIDES
            elif second < 0.0:
                total[LOWER] = total[LOWER] + DECIDES
            elif first + second > 0.0:
                total[BETWEEN] = total[BETWEEN] + DECIDES
    return total


@wp.func
def elected(total: wp.vec3):
    """Return the place with most votes; between the fingers only if it has more than either."""
    if total[BETWEEN] > wp.max(total[UPPER], total[LOWER]):
        return BETWEEN
    if total[UPPER] >= total[LOWER]:
        return UPPER
    return LOWER


@wp.func
def put_vertex(t: TissueArrays, s: ToolShapes, b: int, i: int, upper: int, place: int):
    """Put a vertex that voted at a place; on another finger it sticks where it is now."""
    if wp.length_sq(votes(t, b, i, upper)) > 0.0:
        t.contact_side[b, i] = wp.where(place == BETWEEN, 1.0, -1.0)
        finger = upper + place / 2
        if place != BETWEEN and t.contact_shape[b, i] != finger:
            t.contact_shape[b, i] = finger
            t.stick_point[b, i] = to_link_frame(s.T_world_link[b, finger], t.position[b, i])


@wp.func
def stump_begins(t: TissueArrays, b: int, tube: int, section: int):
    """Return whether a section is the upper side of a ring that is severed."""
    r = section / 2
    return section % 2 == 1 and r < t.n_ring[b, tube] and is_severed(t, b, tube, r)


@wp.func
def agree_on_place(t: TissueArrays, s: ToolShapes, b: int, tube: int, upper: int):
    """Put adjacent rings of a tube that touch either finger at the place of most corners.

    Each stump counts as a tube.
    """
    first = int(0)
    total = wp.vec3()
    n = n_sections(t, b, tube)
    for section in range(n + 1):
        now = wp.vec3()
        if section < n:
            now = section_votes(t, b, tube, section, upper)
        if section == 0 and wp.length_sq(now) > 0.0:
            now = now + joint_votes(t, s, b, tube, upper)
        if wp.length_sq(now) == 0.0 or stump_begins(t, b, tube, section):
            place = elected(total)
            for before in range(first, section):
                for k in range(n_corners(t, b, tube, before)):
                    put_vertex(t, s, b, corner(t, b, tube, before, k), upper, place)
            first = section
            total = wp.vec3()
        total = total + now


@wp.func
def agree_on_sides(t: TissueArrays, s: ToolShapes, b: int, touched: int):
    """Make the tubes agree on their place at both arms' jaws.

    `touched` has a bit for each shape that touches tissue.
    """
    for arm in range(2):
        upper = 4 * arm + 2
        if (touched >> upper) & 3 != 0:
            for tube in range(t.ring.shape[1]):
                agree_on_place(t, s, b, tube, upper)
