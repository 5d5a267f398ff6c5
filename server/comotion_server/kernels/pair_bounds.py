"""Until when two bodies surely stay apart, from what is known at the beginning of a step, without asking for anything.

All flights begin together then, so their poses are at hand: bounding spheres, the distance that was found last less
what the bodies have moved since, and the sphere about a mesh over a plane that stays.
"""

from math import inf

from comotion_server.kernels.flight import STILL
from comotion_server.kernels.impact_query import distance_left
from comotion_server.kernels.jit import lean_jit
from comotion_server.kernels.motion_bounds import Relative, covering_time, first_root, sphere_time
from comotion_server.kernels.rotation import relative_rotation
from comotion_server.kernels.solids import PLANE
from comotion_server.kernels.sphere_impact import are_smooth
from comotion_server.kernels.vectors import ZERO, dot, length, rotated, rotated_back, row, sub


@lean_jit
def _over_plane(solids, flights, plane, mesh, tolerance):
    """How long [s] a mesh stays above a plane; 0 where the plane turns."""
    if flights.kind[plane] != STILL:
        return 0.0
    n = rotated(flights.rotation[plane], row(solids.normal, plane))
    height = dot(n, sub(row(flights.position, mesh), row(flights.position, plane)))
    gap = height - solids.radius[mesh] - tolerance
    if gap <= 0.0:
        return 0.0
    velocity = dot(n, sub(row(flights.velocity, mesh), row(flights.velocity, plane)))
    pull = dot(n, sub(row(flights.acceleration, mesh), row(flights.acceleration, plane)))
    return first_root(gap, velocity, pull)


@lean_jit
def apart_for(solids, flights, a, b, spin, tolerance, memory, R):
    """How long [s] bodies a and b surely stay farther apart than the tolerance, from the origin of all flights on.

    spin (n, 2): `spin_line` of each body; memory: of the pair; R (3, 3): work space. 0 where nothing is known.
    """
    if solids.kind[a] == PLANE or solids.kind[b] == PLANE:
        plane, mesh = (a, b) if solids.kind[a] == PLANE else (b, a)
        return _over_plane(solids, flights, plane, mesh, tolerance)
    radius_a, radius_b = solids.radius[a], solids.radius[b]
    D = sub(row(flights.position, b), row(flights.position, a))
    v = sub(row(flights.velocity, b), row(flights.velocity, a))
    pull = sub(row(flights.acceleration, b), row(flights.acceleration, a))
    reach, time = radius_a + radius_b + tolerance, 0.0
    if length(D) > reach:
        time = sphere_time(Relative(D, v, pull, ZERO, ZERO, ZERO, ZERO), reach)
    if time == inf or are_smooth(solids, a, b):
        return time
    relative_rotation(flights.rotation[a], flights.rotation[b], R)
    left = distance_left(memory, rotated_back(flights.rotation[a], D), R, radius_a, radius_b) - tolerance
    if left <= 0.0:
        return time
    speed = length(v) + spin[a, 0] * radius_a + spin[b, 0] * radius_b
    growth = length(pull) + spin[a, 1] * radius_a + spin[b, 1] * radius_b
    return max(time, covering_time(left, speed, growth))
