"""A deterministic stand-in for the simulation: its bodies move by rules simple enough to be worked out in a test.

Each body is a unit tetrahedron of mass 1 without gravity; v += F dt, then x += v dt; they never turn and never collide. `started` and `go` let a test hold a step.
"""
