"""Store the tissue's state on the device as a structure of arrays, `[environment, capacity]`.

Topology is stored in arrays too. A cut, a clip or a tear therefore rewrites integers and needs no
new compilation. SI units, world frame.
"""

from __future__ import annotations

import warp as wp

wp.config.log_level = wp.LOG_ERROR  # no banner: results go to the same terminal


@wp.struct
class TissueArrays:
    """The arrays that tissue kernels read and write.

    Vertices beyond `n_vertex` are spare vertices for cuts. The stiffness matrix is block-CSR: row i
    is `block[row[i] : row[i + 1]]`, its diagonal first, each block stored transposed. `*_slot`
    arrays hold the places of an element's blocks.
    """

    # vertices
    n_vertex: wp.array(dtype=int)
    rest: wp.array2d(dtype=wp.vec3)
    position: wp.array2d(dtype=wp.vec3)
    velocity: wp.array2d(dtype=wp.vec3)
    previous: wp.array2d(dtype=wp.vec3)
    mass: wp.array2d(dtype=float)
    clamped: wp.array2d(dtype=int)  # by the test machine that pulls at a clip
    fixed: wp.array2d(dtype=int)
    surface: wp.array2d(dtype=int)
    covered: wp.array2d(dtype=int)
    tangled: wp.array2d(dtype=int)
    load: wp.array2d(dtype=wp.vec3)
    force: wp.array2d(dtype=wp.vec3)
    # tetrahedra
    n_tet: wp.array(dtype=int)
    tet: wp.array2d(dtype=wp.vec4i)
    tet_alive: wp.array2d(dtype=int)
    rest_inverse: wp.array2d(dtype=wp.mat33)
    volume: wp.array2d(dtype=float)
    shear: wp.array2d(dtype=float)  # mu of the material
    bulk: wp.array2d(dtype=float)  # lambda of the material
    fibre: wp.array2d(dtype=wp.vec3)  # direction of the collagen at rest
    collagen: wp.array2d(dtype=float)  # the fibres' stiffness, Pa
    folded: wp.array2d(dtype=int)
    mu: wp.array2d(dtype=float)  # the mu that acts on the element now
    lam: wp.array2d(dtype=float)  # likewise
    tet_slot: wp.array3d(dtype=int)
    # the elements' stiffness, kept from step to step (see `assembly`)
    elastic: wp.array2d(dtype=wp.mat33)  # blocks in the layout of `block`
    stiffness_at: wp.array2d(dtype=wp.vec3)  # positions of the vertices at that time
    stiffness_holds: wp.array(dtype=int)
    # ties: a tube's vertex (corner 0, weight 1) held to a point inside a sac's tetrahedron
    tie_corner: wp.array3d(dtype=int)
    tie_weight: wp.array3d(dtype=float)
    tie_stiffness: wp.array2d(dtype=float)
    tie_strength: wp.array2d(dtype=float)
    tie_slot: wp.array3d(dtype=int)
    # links: springs between two vertices (a clip's squeeze, connective strands)
    link: wp.array2d(dtype=wp.vec2i)
    link_rest: wp.array2d(dtype=float)
    link_stiffness: wp.array2d(dtype=float)
    link_strength: wp.array2d(dtype=float)
    link_slot: wp.array3d(dtype=int)
    # strands that an instrument has caught: the shape, -1 for none; contact point and outward
    # normal in the shape's link frame
    strand_shape: wp.array2d(dtype=int)
    strand_point: wp.array2d(dtype=wp.vec3)
    strand_normal: wp.array2d(dtype=wp.vec3)
    # anchors: springs from a vertex to a point of the world (the liver bed's connective tissue)
    anchor: wp.array2d(dtype=int)
    anchor_point: wp.array2d(dtype=wp.vec3)
    anchor_stiffness: wp.array2d(dtype=float)
    anchor_strength: wp.array2d(dtype=float)
    # tool contact: the shape that touches a vertex, its sticking point, force and stiffness
    contact_shape: wp.array2d(dtype=int)
    contact_side: wp.array2d(dtype=float)
    stick_point: wp.array2d(dtype=wp.vec3)
    contact_force: wp.array2d(dtype=wp.vec3)
    contact_stiffness: wp.array2d(dtype=wp.mat33)
    # liver bed
    bed_point: wp.array(dtype=wp.vec3)
    bed_normal: wp.array(dtype=wp.vec3)
    bed_along: wp.array(dtype=wp.vec3)
    bed_edge: wp.array(dtype=float)
    bed_force: wp.array(dtype=wp.vec3)
    # tubes: rings of outer vertices, and the rings of the side above a cut; n_ring is 0 for an
    # absent tube. The first `n_colliding` tubes collide with each other; other tubes are behind.
    ring: wp.array4d(dtype=int)
    n_ring: wp.array2d(dtype=int)
    n_colliding: wp.array(dtype=int)
    ring_above: wp.array4d(dtype=int)
    ring_centre: wp.array3d(dtype=wp.vec3)
    ring_centre_above: wp.array3d(dtype=wp.vec3)
    tube_radius: wp.array2d(dtype=float)
    neck: wp.array3d(dtype=int)  # vertices of the gallbladder's narrowest rings
    # the gallbladder's skin: triangles, oriented outward; those near the tubes now, with a ball
    # around each; and which rings of the tubes can touch it
    n_skin: wp.array(dtype=int)
    skin: wp.array2d(dtype=wp.vec3i)
    skin_tet: wp.array2d(dtype=int)  # the element behind each triangle
    n_skin_near: wp.array(dtype=int)
    skin_near: wp.array2d(dtype=int)
    skin_middle: wp.array2d(dtype=wp.vec3)
    skin_reach: wp.array2d(dtype=float)
    ring_beside_sac: wp.array3d(dtype=int)
    # bars: rigid bodies that vertices carry (closed clips). Middle and axis are weighted sums of
    # the vertices' positions; balls in a row touch instruments and other bars (see `bar_contact`)
    n_bar: wp.array(dtype=int)
    bar_reach: wp.array2d(dtype=float)  # from the middle to the last ball, m
    bar_radius: wp.array2d(dtype=float)
    bar_count: wp.array2d(dtype=int)
    bar_vertex: wp.array3d(dtype=int)
    bar_middle: wp.array3d(dtype=float)  # weights
    bar_axis: wp.array3d(dtype=float)
    bar_scale: wp.array2d(dtype=float)  # one over the length of the weighted sum for the axis
    bar_in_jaws: wp.array2d(dtype=int)  # the right jaws have closed the bar and still hold it
    bar_force: wp.array2d(dtype=wp.vec3)  # force of instruments and other bars
    ball: wp.array3d(dtype=wp.vec3)
    ball_before: wp.array3d(dtype=wp.vec3)
    ball_shape: wp.array3d(dtype=int)
    ball_force: wp.array3d(dtype=wp.vec3)
    ball_stiffness: wp.array3d(dtype=wp.mat33)
    # walls: tube or sac of each element, its segment or patch (see `walls`), and their loads
    wall: wp.array2d(dtype=wp.vec2i)
    segment_gradient: wp.array3d(dtype=wp.vec3)
    segment_direction: wp.array3d(dtype=wp.vec3)
    segment_volume: wp.array3d(dtype=float)
    segment_pull: wp.array3d(dtype=float)
    patch_shape: wp.array2d(dtype=wp.mat33)
    patch_volume: wp.array2d(dtype=float)
    patch_stiffness: wp.array2d(dtype=float)
    patch_stretch: wp.array2d(dtype=float)
    # linear system
    row: wp.array2d(dtype=int)
    column: wp.array2d(dtype=int)
    block: wp.array2d(dtype=wp.mat33)
    inverse_diagonal: wp.array2d(dtype=wp.mat33)
    residual: wp.array2d(dtype=wp.vec3)
    preconditioned: wp.array2d(dtype=wp.vec3)
    direction: wp.array2d(dtype=wp.vec3)
    product: wp.array2d(dtype=wp.vec3)
    step: wp.array2d(dtype=wp.vec3)
    iterations: wp.array(dtype=int)
    # parts that move as rigid bodies in the preconditioner, and the factor of their matrix
    n_part: wp.array(dtype=int)
    part: wp.array2d(dtype=int)
    held: wp.array2d(dtype=int)  # whether the body holds the piece that a vertex belongs to
    has_broken: wp.array(dtype=int)  # whether a tie or an anchor broke in this step
    part_middle: wp.array2d(dtype=wp.vec3)
    part_count: wp.array2d(dtype=float)
    arm: wp.array2d(dtype=wp.vec3)
    factor: wp.array2d(dtype=wp.spatial_vector)
    factor_first: wp.array2d(dtype=int)
    factor_start: wp.array2d(dtype=int)
    factor_pivot: wp.array2d(dtype=float)
    motion: wp.array2d(dtype=wp.spatial_vector)


@wp.struct
class ToolShapes:
    """Instruments as rounded patches: all points within `radius` of a rectangle.

    The rectangle is `{a + t (b - a) + s w, 0 <= t <= 1, -1 <= s <= 1}`; w = 0 is a capsule.
    """

    a: wp.array2d(dtype=wp.vec3)
    b: wp.array2d(dtype=wp.vec3)
    half_width: wp.array2d(dtype=wp.vec3)
    radius: wp.array2d(dtype=float)
    friction: wp.array2d(dtype=float)
    T_world_link: wp.array2d(dtype=wp.mat44)
    T_world_link_before: wp.array2d(dtype=wp.mat44)  # one tissue step ago
    force: wp.array2d(dtype=wp.vec3)
    torque: wp.array2d(dtype=wp.vec3)


# The arrays that a step or an event changes; other arrays follow from the organ or from these.
STATE = (
    "n_vertex", "n_part", "part", "position", "rest", "rest_inverse", "volume", "velocity", "mass",
    "surface", "covered", "clamped", "load", "tet", "tet_alive", "folded",
    "mu", "lam", "stiffness_at", "stiffness_holds",
    "tie_stiffness", "link", "link_rest", "link_stiffness", "link_strength", "anchor_stiffness",
    "strand_shape", "strand_point", "strand_normal",
    "contact_shape", "contact_side", "contact_force", "stick_point", "ring_above",
    "bed_force",
)  # fmt: skip
