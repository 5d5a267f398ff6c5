"""Proven lower bounds of the distance of one box or triangle to eight others, eight at a time.

The eight lie side by side in one block of numbers: a row per number, a column (lane) per box. Each loop over the lanes
is straight arithmetic without branches, so that the compiler computes all lanes with one instruction: eight boxes cost
little more than one. Its length is read from the array, because a loop of known length is unrolled instead.

Rows of a block: CENTRE, AXES (one after the other), HALF of the boxes, CORNERS of the triangles in them, zeros in lanes
that hold no triangle. Bounds of lanes beyond the last one in use mean nothing.
"""

from math import sqrt

from comotion_server.kernels.jit import lean_jit

LANES = 8  # doubles in one register of AVX-512; half the registers do it in two turns
CENTRE, AXES, HALF, CORNERS, ROWS = 0, 3, 12, 15, 24
PARALLEL = 1e-2  # squared sine of two box axes below which their cross product is not used: it amplifies rounding by 10
ROUNDING = 2e-15  # added to a squared sine that is divided by, so that the bound stays one
NONE = -1e300  # a bound that says nothing, smaller than any other


@lean_jit
def _outside(x, y, z):
    """Distance that the gaps along three orthogonal axes prove; of overlapping boxes the least overlap, negative."""
    deepest = max(x, y, z)
    x, y, z = max(x, 0.0), max(y, 0.0), max(z, 0.0)
    apart = sqrt(x * x + y * y + z * z)
    return apart if deepest > 0.0 else deepest


@lean_jit
def _edges_gap(c1, c2, a1, a2, b1, b2, m1, m2, k1, k2, m):
    """Gap along the cross product of one axis of each box: the arguments are those of the two other axes."""
    squared = 1.0 - m * m
    gap = abs(c2 * m1 - c1 * m2) - a1 * abs(m2) - a2 * abs(m1) - b1 * abs(k2) - b2 * abs(k1)
    gap = gap / sqrt(max(squared, PARALLEL) + ROUNDING)
    return gap if squared >= PARALLEL else NONE


@lean_jit
def box_bounds(blocks, node, box, normals, side, bounds):
    """Lower bounds (8,) of the distance of one box to eight: fifteen separating axes, and along a unit normal.

    blocks[node] holds the eight; box (16,): centre, axes, half, in the frame of the eight; normals[side] (3,): from the
    one to the eight. Arrays are passed whole: a slice of one would cost as much as the arithmetic.
    """
    n0, n1, n2 = normals[side, 0], normals[side, 1], normals[side, 2]
    bx, by, bz = box[0], box[1], box[2]
    e0, e1, e2 = box[3], box[4], box[5]
    f0, f1, f2 = box[6], box[7], box[8]
    g0, g1, g2 = box[9], box[10], box[11]
    u, v, w = box[12], box[13], box[14]
    reach = u * abs(e0 * n0 + e1 * n1 + e2 * n2)
    reach += v * abs(f0 * n0 + f1 * n1 + f2 * n2) + w * abs(g0 * n0 + g1 * n1 + g2 * n2)
    for l in range(blocks.shape[2]):
        x, y, z = bx - blocks[node, 0, l], by - blocks[node, 1, l], bz - blocks[node, 2, l]
        h0, h1, h2 = blocks[node, 3, l], blocks[node, 4, l], blocks[node, 5, l]
        i0, i1, i2 = blocks[node, 6, l], blocks[node, 7, l], blocks[node, 8, l]
        j0, j1, j2 = blocks[node, 9, l], blocks[node, 10, l], blocks[node, 11, l]
        p, q, r = blocks[node, 12, l], blocks[node, 13, l], blocks[node, 14, l]
        along = p * abs(h0 * n0 + h1 * n1 + h2 * n2)
        along += q * abs(i0 * n0 + i1 * n1 + i2 * n2) + r * abs(j0 * n0 + j1 * n1 + j2 * n2)
        gap = -(n0 * x + n1 * y + n2 * z) - along - reach
        xx, xy, xz = h0 * e0 + h1 * e1 + h2 * e2, h0 * f0 + h1 * f1 + h2 * f2, h0 * g0 + h1 * g1 + h2 * g2
        yx, yy, yz = i0 * e0 + i1 * e1 + i2 * e2, i0 * f0 + i1 * f1 + i2 * f2, i0 * g0 + i1 * g1 + i2 * g2
        zx, zy, zz = j0 * e0 + j1 * e1 + j2 * e2, j0 * f0 + j1 * f1 + j2 * f2, j0 * g0 + j1 * g1 + j2 * g2
        cx, cy, cz = h0 * x + h1 * y + h2 * z, i0 * x + i1 * y + i2 * z, j0 * x + j1 * y + j2 * z
        own = _outside(
            abs(cx) - p - u * abs(xx) - v * abs(xy) - w * abs(xz),
            abs(cy) - q - u * abs(yx) - v * abs(yy) - w * abs(yz),
            abs(cz) - r - u * abs(zx) - v * abs(zy) - w * abs(zz),
        )
        other = _outside(
            abs(e0 * x + e1 * y + e2 * z) - u - p * abs(xx) - q * abs(yx) - r * abs(zx),
            abs(f0 * x + f1 * y + f2 * z) - v - p * abs(xy) - q * abs(yy) - r * abs(zy),
            abs(g0 * x + g1 * y + g2 * z) - w - p * abs(xz) - q * abs(yz) - r * abs(zz),
        )
        gap = max(gap, own, other)
        gap = max(gap, _edges_gap(cy, cz, q, r, v, w, yx, zx, xy, xz, xx))
        gap = max(gap, _edges_gap(cy, cz, q, r, w, u, yy, zy, xz, xx, xy))
        gap = max(gap, _edges_gap(cy, cz, q, r, u, v, yz, zz, xx, xy, xz))
        gap = max(gap, _edges_gap(cz, cx, r, p, v, w, zx, xx, yy, yz, yx))
        gap = max(gap, _edges_gap(cz, cx, r, p, w, u, zy, xy, yz, yx, yy))
        gap = max(gap, _edges_gap(cz, cx, r, p, u, v, zz, xz, yx, yy, yz))
        gap = max(gap, _edges_gap(cx, cy, p, q, v, w, xx, yx, zy, zz, zx))
        gap = max(gap, _edges_gap(cx, cy, p, q, w, u, xy, yy, zz, zx, zy))
        bounds[l] = max(gap, _edges_gap(cx, cy, p, q, u, v, xz, yz, zx, zy, zz))
