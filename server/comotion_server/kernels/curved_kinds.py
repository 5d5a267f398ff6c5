"""Kinds of shapes and the lengths that make them.

`size` of a shape is a row of four lengths [m]; `axis` is a unit vector of the body frame: a plane's normal, out of the
solid, or the direction of a capsule, cylinder or pipe. Everything is about the body's origin.
"""

MESH, PLANE, SPHERE, CAPSULE, CYLINDER, PIPE = 0, 1, 2, 3, 4, 5

# of a sphere, capsule or cylinder: its radius; of the last two: half its length, a capsule's without the round ends
RADIUS, HALF_LENGTH = 0, 1
# of a pipe: both radii, half its length, and 1 where flat discs close both ends
INNER, OUTER, HALF, CAPS = 0, 1, 2, 3
