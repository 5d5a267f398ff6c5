"""P6: the distance of two meshes and its closest points, by a walk down both trees of boxes.

Everything is computed in the frame of body a, with the relative pose taken from the difference of the positions, so a
scene far from the world's origin keeps its digits. The walk goes from pair to pair of slots (`lane_tree`): the smaller
of the two boxes is compared with all boxes, at most eight, below the larger one, in one turn (`lanes`), and where both
are triangles with all triangles there. What is proven to be no nearer than the best pair so far is dropped; the rest is
walked on, the nearest first. Among the bounds is the gap along the direction of the best pair, valid for *any* unit n:
n . (c_b - c_a) - r_a(n) - r_b(n). A last witness pair, if there is one, gives the first upper bound.

Legend: R (3, 3) and t turn points y of body b's frame into body a's: R y + t. `best` is (distance, point on a, point on
b, unit direction from a to b, triangle of a, triangle of b), all in body a's frame. `turns` (2, 3, 4) holds R, t and
their inverse, `towards` (2, 3) the direction n from a to b in b's frame, and -n in a's.
"""

from math import inf

import numpy as np

from comotion_server.kernels.jit import jit, lean_jit
from comotion_server.kernels.lane_tree import SIZE
from comotion_server.kernels.lanes import AXES, HALF, LANES, box_bounds
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.triangle_distance import triangle_points
from comotion_server.kernels.triangle_lanes import triangle_bounds
from comotion_server.kernels.vectors import ZERO, add, along, rotated, rotated_back, row, scaled, sub

STACK = 1024  # pairs; seven are left behind per level of both trees, which have at most 48 + log2(triangles) levels
TO_A, TO_B = 0, 1  # rows of `turns` and `towards`
BOX_TURNS, TRIANGLE_TURNS, FULL_PAIRS = 0, 1, 2  # of what a walk counts
SLACK = 2e-15  # of the bodies' sizes: rounding of a bound or a distance; surfaces nearer than this touch


@lean_jit
def corners(m, triangle):
    """The three corners of a triangle in its body's frame."""
    return (
        row(m.vertices, m.triangles[triangle, 0]),
        row(m.vertices, m.triangles[triangle, 1]),
        row(m.vertices, m.triangles[triangle, 2]),
    )


@lean_jit
def corners_moved(m, triangle, R, t):
    """The three corners of a triangle of body b in body a's frame."""
    a, b, c = corners(m, triangle)
    return add(rotated(R, a), t), add(rotated(R, b), t), add(rotated(R, c), t)


@lean_jit
def _triangle_pair(vertices, triangles, triangle_a, triangle_b, R, t):
    """`best` of one pair of triangles."""
    a, b, c = triangles[triangle_a, 0], triangles[triangle_a, 1], triangles[triangle_a, 2]
    d, e, f = triangles[triangle_b, 0], triangles[triangle_b, 1], triangles[triangle_b, 2]
    b0, b1, b2 = (
        add(rotated(R, row(vertices, d)), t),
        add(rotated(R, row(vertices, e)), t),
        add(rotated(R, row(vertices, f)), t),
    )
    distance, p, q, n = triangle_points(row(vertices, a), row(vertices, b), row(vertices, c), b0, b1, b2)
    return distance, p, q, n, triangle_a, triangle_b


@lean_jit
def _worth(reach, slack, distance):
    """What a bound must be below to be worth a look: the reach, or clearly below the best distance so far."""
    return min(reach, max(distance - slack, 0.5 * distance))


@lean_jit
def _touching(best):
    """`best` of surfaces that meet, to rounding: distance 0 and one common point; not a number stays what it is."""
    middle = scaled(add(best[1], best[2]), 0.5)
    return 0.0 * best[0], middle, middle, ZERO, best[4], best[5]


@jit
def work_space():
    """What a walk writes to: slots (STACK, 2), their bounds (STACK,), turns, towards, box, corners, two bounds (8,).

    And counts (3,): boxes against nodes, triangles against nodes, pairs of triangles in full.
    """
    return (
        np.empty((STACK, 2), np.int64),
        np.empty(STACK),
        np.empty((2, 3, 4)),
        np.empty((2, 3)),
        np.empty(16),
        np.empty(9),
        np.empty(LANES),
        np.empty(LANES),
        np.zeros(3, np.int64),
    )


@lean_jit
def _set_turns(R, t, turns):
    """R, t and their inverse."""
    back = rotated_back(R, t)
    for i in range(3):
        for k in range(3):
            turns[TO_A, i, k], turns[TO_B, k, i] = R[i, k], R[i, k]
        turns[TO_A, i, 3], turns[TO_B, i, 3] = t[i], -back[i]


@lean_jit
def _set_towards(n, turns, towards):
    """The direction n (body a's frame, from a to b) for lanes of body b, and reversed for lanes of body a."""
    for i in range(3):
        towards[TO_A, i] = -n[i]
        towards[TO_B, i] = turns[TO_B, i, 0] * n[0] + turns[TO_B, i, 1] * n[1] + turns[TO_B, i, 2] * n[2]


@lean_jit
def _turn_box(boxes, slot, turns, side, box):
    """The box (16,) of a slot in the other body's frame."""
    for i in range(3):
        x, y, z = turns[side, i, 0], turns[side, i, 1], turns[side, i, 2]
        box[i] = x * boxes[slot, 0] + y * boxes[slot, 1] + z * boxes[slot, 2] + turns[side, i, 3]
        for k in range(3):
            axis = AXES + 3 * k
            box[axis + i] = x * boxes[slot, axis] + y * boxes[slot, axis + 1] + z * boxes[slot, axis + 2]
        box[HALF + i] = boxes[slot, HALF + i]


@lean_jit
def _turn_corners(vertices, triangles, triangle, turns, side, corners):
    """The corners (9,) of a triangle in the other body's frame."""
    for c in range(3):
        v = triangles[triangle, c]
        for i in range(3):
            x, y, z = turns[side, i, 0], turns[side, i, 1], turns[side, i, 2]
            corners[3 * c + i] = x * vertices[v, 0] + y * vertices[v, 1] + z * vertices[v, 2] + turns[side, i, 3]


@lean_jit
def _push(slots, gaps, top, bottom, slot_a, slot_b, gap):
    """Put a pair on the stack, above `bottom` in the order of falling bounds; the height of the stack."""
    k = top
    while k > bottom and gaps[k - 1] < gap:
        slots[k, 0], slots[k, 1], gaps[k] = slots[k - 1, 0], slots[k - 1, 1], gaps[k - 1]
        k -= 1
    slots[k, 0], slots[k, 1], gaps[k] = slot_a, slot_b, gap
    return top + 1


@lean_jit
def _nearest(bounds, used, limit):
    """The lane with the least bound below the limit; -1 where there is none."""
    lane = -1
    for l in range(used):
        if bounds[l] < limit:
            lane, limit = l, bounds[l]
    return lane


@lean_jit
def _triangles_below(vertices, triangles, link, blocks, below, used, one, below_a, R, t, room, reach, slack, found):
    """(lower bound of what was passed over, best) after one triangle against those below a node, the nearest first.

    one: the triangle; below_a: whether the node is of body a; room: the triangle's corners turned to the node's frame,
    bounds of what to look at, work space, counts; found: (lower bound, best) before.
    """
    lower, best = found
    corners_one, bounds, narrower, counts = room
    counts[TRIANGLE_TURNS] += 1
    triangle_bounds(blocks, below, corners_one, narrower)
    for l in range(used):
        bounds[l] = max(bounds[l], narrower[l])
    lane = _nearest(bounds, used, inf)
    while lane >= 0:
        limit = _worth(reach, slack, best[0])
        if bounds[lane] >= limit:
            return min(lower, bounds[lane]), best
        bounds[lane] = inf
        counts[FULL_PAIRS] += 1
        other = ~link[LANES * below + lane]
        triangle_a, triangle_b = (other, one) if below_a else (one, other)
        pair = _triangle_pair(vertices, triangles, triangle_a, triangle_b, R, t)
        if pair[0] < best[0]:
            best = pair
            if best[0] <= slack:
                return lower, best
        elif pair[0] >= limit:
            lower = min(lower, pair[0])
        lane = _nearest(bounds, used, inf)
    return lower, best


@lean_jit
def closest_points(m, shape_a, shape_b, R, t, reach, witness_a, witness_b, work):
    """`best` of two meshes, exact if its distance is below `reach` [m].

    Otherwise the distance is a proven lower bound, at least `reach`, and points and triangles are those of a pair seen
    on the way. witness_a, witness_b: a triangle pair to begin with (indices over all shapes; -1: none); work: of
    `work_space`. A distance 0 ends the walk: the triangles intersect.
    """
    vertices, triangles, boxes, blocks, link, used = m.vertices, m.triangles, m.box, m.block, m.link, m.used
    slots, gaps, turns, towards, box, corners_one, bounds, pair_bounds, counts = work
    slack = SLACK * (m.size[shape_a] + m.size[shape_b])
    if witness_a < 0 or witness_b < 0:
        witness_a, witness_b = m.triangle_start[shape_a], m.triangle_start[shape_b]
    best = _triangle_pair(vertices, triangles, witness_a, witness_b, R, t)
    if not best[0] > slack:
        return _touching(best)
    counts[FULL_PAIRS] += 1
    _set_turns(R, t, turns)
    _set_towards(best[3], turns, towards)
    limit, lower, height = _worth(reach, slack, best[0]), inf, 1
    slots[0, 0], slots[0, 1], gaps[0] = m.top[shape_a], m.top[shape_b], -inf
    while height > 0:
        height -= 1
        slot_a, slot_b, gap = slots[height, 0], slots[height, 1], gaps[height]
        if gap >= limit:
            lower = min(lower, gap)
            continue
        link_a, link_b = link[slot_a], link[slot_b]
        if link_a < 0 and link_b < 0:  # two meshes of one triangle each: theirs was the first pair
            continue
        below_a = link_b < 0 or (link_a >= 0 and boxes[slot_a, SIZE] >= boxes[slot_b, SIZE])
        side, one, below = (TO_A, slot_b, link_a) if below_a else (TO_B, slot_a, link_b)
        _turn_box(boxes, one, turns, side, box)
        box_bounds(blocks, below, box, towards, side, bounds)
        counts[BOX_TURNS] += 1
        bottom, pairs_left = height, False
        for l in range(used[below]):
            slot, bound = LANES * below + l, max(bounds[l], gap)
            pair_bounds[l] = inf
            if bound >= limit:
                lower = min(lower, bound)
            elif link[one] < 0 and link[slot] < 0:
                pair_bounds[l], pairs_left = bound, True
            elif below_a:
                height = _push(slots, gaps, height, bottom, slot, slot_b, bound)
            else:
                height = _push(slots, gaps, height, bottom, slot_a, slot, bound)
        if pairs_left:
            before, triangle, room = best[0], ~link[one], (corners_one, pair_bounds, bounds, counts)
            _turn_corners(vertices, triangles, triangle, turns, side, corners_one)
            lower, best = _triangles_below(
                vertices, triangles, link, blocks, below, used[below], triangle, below_a, R, t,
                room, reach, slack, (lower, best),
            )  # fmt: skip
            if best[0] <= slack:
                return _touching(best)
            if best[0] < before:
                limit = _worth(reach, slack, best[0])
                _set_towards(best[3], turns, towards)
    if best[0] < reach:
        return best
    return min(best[0], lower), best[1], best[2], best[3], best[4], best[5]


@jit
def closest_points_of_rows(
    rows, m, shape_of_body, positions, rotations, pairs, reach, witness, distance, point_a, point_b, normal
):
    """Distance and closest points of some pairs of bodies (P6), those in `rows`; other rows stay as they are.

    m: MeshArrays; shape_of_body (bodies,) int64; positions (bodies, 3) [m]; rotations (bodies, 3, 3) body to world;
    pairs (k, 2) int64 body indices; reach (k,) [m]: the result is exact if the distance is below it (inf: always).
    In and out: witness (k, 2) int64, the triangle (index within its shape) of either body that holds its closest
    point; the walk starts from it; -1 where there is none yet.
    Out: distance (k,) [m], exactly 0 if and only if the surfaces intersect (P7), then the witness is a pair of
    triangles that does; where the distance is not below reach, a proven lower bound of it, not below reach either;
    point_a, point_b (k, 3) world [m]; normal (k, 3) world, unit vector from a to b, zero for distance 0. Beyond reach
    points, normal and witness belong to some pair of triangles, good to start from.
    """
    work, R = work_space(), np.empty((3, 3))
    for k in rows:
        a, b = pairs[k, 0], pairs[k, 1]
        shape_a, shape_b = shape_of_body[a], shape_of_body[b]
        start_a, start_b = m.triangle_start[shape_a], m.triangle_start[shape_b]
        relative_rotation(rotations[a], rotations[b], R)
        t = rotated_back(rotations[a], sub(row(positions, b), row(positions, a)))
        known = witness[k, 0] >= 0 and witness[k, 1] >= 0
        witness_a = start_a + witness[k, 0] if known else -1
        witness_b = start_b + witness[k, 1] if known else -1
        d, p, q, n, i, j = closest_points(m, shape_a, shape_b, R, t, reach[k], witness_a, witness_b, work)
        distance[k] = d
        point_a[k] = along(row(positions, a), 1.0, rotated(rotations[a], p))
        point_b[k] = along(row(positions, a), 1.0, rotated(rotations[a], q))
        normal[k] = rotated(rotations[a], n)
        witness[k, 0], witness[k, 1] = i - start_a, j - start_b


@jit
def closest_points_of_pairs(
    m, shape_of_body, positions, rotations, pairs, reach, witness, distance, point_a, point_b, normal
):
    """As `closest_points_of_rows`, for all pairs."""
    rows = np.arange(len(pairs))
    closest_points_of_rows(
        rows, m, shape_of_body, positions, rotations, pairs, reach, witness, distance, point_a, point_b, normal
    )
