"""P7: where the interiors of two triangles cross.

Moeller (1997): two triangles whose planes cut each other meet where the intervals that they cut from the common line
overlap. The ends of an interval are where edges pass through the other's plane, so the intervals overlap in more than a
point where an edge of one passes through the inside of the other. That is asked here, by the signs of determinants
(Guigue and Devillers 2003) and never by the ends themselves, which are noise when the planes are nearly the same.
Contacts without a passage (a vertex or an edge that touches, coplanar overlap, triangles without area) have feature
pairs at distance zero and are found by the distance (P5).
"""

from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.orientation import orientation, volume_exactly
from comotion_server.kernels.vectors import ZERO, along, sub


@lean_jit
def _passes_through(p, q, a, b, c):
    """Whether the line through p and q passes strictly inside the triangle a, b, c (which it is known not to miss)."""
    side = orientation(p, q, a, b)
    return side != 0 and orientation(p, q, b, c) == side and orientation(p, q, c, a) == side


@lean_jit
def _passage_point(p, q, a, b, c):
    """The point of p q in the plane of a, b, c, which lie on different sides of it."""
    before, after = abs(volume_exactly(a, b, c, p)), abs(volume_exactly(a, b, c, q))
    return along(p, before / (before + after), sub(q, p))


@lean_jit
def edge_passage(a0, a1, a2, b0, b1, b2):
    """(found, point): an edge of triangle a that passes through the inside of triangle b."""
    side0 = orientation(b0, b1, b2, a0)
    side1 = orientation(b0, b1, b2, a1)
    side2 = orientation(b0, b1, b2, a2)
    if side0 * side1 < 0 and _passes_through(a0, a1, b0, b1, b2):
        return True, _passage_point(a0, a1, b0, b1, b2)
    if side1 * side2 < 0 and _passes_through(a1, a2, b0, b1, b2):
        return True, _passage_point(a1, a2, b0, b1, b2)
    if side2 * side0 < 0 and _passes_through(a2, a0, b0, b1, b2):
        return True, _passage_point(a2, a0, b0, b1, b2)
    return False, ZERO


@lean_jit
def crossing_point(a0, a1, a2, b0, b1, b2):
    """(found, point): a point common to two triangles that pass through each other."""
    found, point = edge_passage(a0, a1, a2, b0, b1, b2)
    if found:
        return found, point
    return edge_passage(b0, b1, b2, a0, a1, a2)
