"""Bodies that tumble in boxes, on planes and through each other: parts of a scene, and what else it is given."""

import numpy as np
from event_scenes import Part, centred, inside_out
from meshes_by_hand import l_shape, torus

from comotion_server.meshes import box, prism

ELL, RING, CUBE = centred(l_shape()), centred(torus(24, 12)), box([1.0, 1.0, 1.0])
ACROSS = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])


def room(size):
    return Part(inside_out(box(size)), density=0.0)


def tumbling_cube():
    return [Part((0, 0, 1.0)), Part(CUBE, (0, 0, 2.0), (0.1, 0.2, 0), (0.4, 0.5, 0.3))], {"gravity": (0, 0, -1.0)}


def ells_in_a_box():
    return [
        room([5.0, 5.0, 5.0]),
        Part(ELL, (1.0, 0, 0), (0.7, 0.5, -0.3), (0.5, -0.4, 0.6)),
        Part(ELL, (-1.2, 0, 0), (-0.7, 0.5, 0.3), (0.5, 0.4, 0.6)),
    ], {}


def ells_and_a_ring():
    places = ((1.8, 1.5, 0), (-1.8, 1.5, 0.5), (0, -1.6, 1.5))
    ells = [Part(ELL, x, np.roll((0.7, 0.5, -0.3), k), np.roll((0.5, -0.4, 0.6), k)) for k, x in enumerate(places)]
    return [room([7.0, 7.0, 7.0]), *ells, Part(RING, (0, -1.6, -1.8), (0.3, 0.2, 0.6), (0.3, 0.1, 0))], {}


def ell_pulled_into_a_notch():
    held = Part(ELL, density=0.0)
    pulled = Part(ELL, (1.9, 1.9, 0.0), (0, 0, 0), (0.1, 0.2, 0.3), R=np.diag([-1.0, -1.0, 1.0]))
    return [held, pulled, room([9.0, 9.0, 9.0])], {"gravity": (-0.7, -0.7, 0.0)}


def linked_rings():
    return [
        Part(RING, (0, 0, 0), (0, 0, 0), (0.3, 0.2, -0.5)),
        Part(RING, (1.0, 0, 0), (0.4, 0.3, 0.5), (0.1, -0.3, 0.2), R=ACROSS),
    ], {}


def hanging_ring():
    return [
        Part(RING, density=0.0),
        Part(RING, (1.0, 0, -0.1), (0.1, 0, 0), (0.2, 0.1, 0.3), R=ACROSS),
    ], {"gravity": (0, 0, -1.0)}


def prisms_in_a_box():
    rng = np.random.default_rng(5)
    shape = centred(prism(0.5, 0.5, 0.4))
    grid = np.stack(np.meshgrid(*3 * [np.arange(3.0)]), axis=-1).reshape(-1, 3)[:20] - 1.0
    return [room([3.0, 3.0, 3.0])] + [Part(shape, 0.8 * x, rng.normal(size=3), rng.normal(size=3)) for x in grid], {}


SCENES = {
    "tumbling cube": tumbling_cube,
    "two L in a box": ells_in_a_box,
    "three L and a ring in a box": ells_and_a_ring,
    "L pulled into a notch": ell_pulled_into_a_notch,
    "linked rings": linked_rings,
    "ring hanging in a ring": hanging_ring,
    "prisms in a box": prisms_in_a_box,
}
