"""Queries that start touching and separating, hundreds in a row: two bodies that bounce at several restitutions."""

import numpy as np
import pytest
from meshes_by_hand import l_shape, torus
from two_body_events import TwoBodies

from comotion_server.geometry.contact_time import near_distance
from comotion_server.geometry.motion import Motion
from comotion_server.kernels.impact_query import COUNTS, LATER, MEETS, NONE, TOUCHES
from comotion_server.meshes import TriangleMesh, box, mass_properties

TOLERANCE = 1e-9
FAR_FUTURE = 1e6
LONGEST = 30  # steps of one pair of triangles
LEAST_GAP = 0.45  # of the tolerance; steps aim at half


def centred(mesh):
    properties = mass_properties(mesh.vertices, mesh.triangles)
    return TriangleMesh(mesh.vertices - properties.centre, mesh.triangles), properties


def ell_in_box():
    """An L, free to tumble in a closed box."""
    ell, properties = centred(l_shape())
    box_motion = Motion((np.eye(3), np.zeros(3)))
    flight = Motion((np.eye(3), np.zeros(3)), (0.7, 0.5, -0.3), (0.5, -0.4, 0.6), inertia=properties.inertia)
    return [box([5.0, 5.0, 5.0]), ell], (box_motion, flight), [np.inf, properties.volume]


def linked_tori():
    """Two free rings through each other."""
    ring, properties = centred(torus(24, 12))
    across = np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
    one = Motion((np.eye(3), np.zeros(3)), angular_velocity=(0.3, 0.2, -0.5), inertia=properties.inertia)
    other = Motion((across, (1.0, 0, 0)), (0.4, 0.3, 0.5), (0.1, -0.3, 0.2), inertia=properties.inertia)
    return [ring, TriangleMesh(ring.vertices, ring.triangles)], (one, other), [properties.volume] * 2


SCENES = {"L in a box": ell_in_box, "linked tori": linked_tori}


def rounding_of_time(time, closing):
    """How far apart two times of the same contact may be: the gap at a hit is right to 1e-6 of the target and rounding.

    And the attitude of a free top to 1e-13 per radian, of which there are a few.
    """
    return 8 * np.spacing(time) + (1e-6 * TOLERANCE + 1e-14 + 1e-12) / closing


def two_bodies(scene, tolerance=TOLERANCE):
    meshes, motions, masses = SCENES[scene]()
    return TwoBodies(meshes, motions, masses, min(map(near_distance, meshes)), tolerance)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("restitution", [1.0, 0.5, 0.1, 1e-3])
def test_every_bounce_gets_away(scene, restitution):
    bodies = two_bodies(scene)
    before = bodies.energy()
    story = bodies.run(150, restitution, FAR_FUTURE)
    assert set(story.ends) <= {MEETS, TOUCHES, NONE}
    assert len(story.times) > 50
    assert story.longest <= LONGEST
    assert story.gap >= LEAST_GAP * TOLERANCE
    if restitution == 1.0:
        assert min(story.times) > 0.0
        assert story.energy == pytest.approx(before, rel=1e-13)


@pytest.mark.parametrize("tolerance", [1e-10, 1e-8, 1e-7, 1e-5])
def test_the_cost_does_not_depend_on_the_tolerance(tolerance):
    bodies = two_bodies("L in a box", tolerance)
    story = bodies.run(60, 1.0, FAR_FUTURE)
    assert set(story.ends) <= {MEETS, TOUCHES}
    assert story.longest <= LONGEST
    assert story.gap >= LEAST_GAP * tolerance
    assert story.counts[0] < 60 * 60
    assert story.counts[1] < 60 * 6


@pytest.mark.parametrize("scene", SCENES)
def test_a_query_that_is_stopped_at_keys_ends_where_a_whole_one_does(scene):
    whole, cut = two_bodies(scene), two_bodies(scene)
    counts = np.zeros(COUNTS, np.int64)
    status, found = whole.query(FAR_FUTURE, counts)
    key, ends = 0.0, []
    while True:
        before = cut.memory[0]
        end, findings = cut.query(FAR_FUTURE, counts, key)
        ends.append(end)
        assert cut.memory[0] >= before
        if ends[-1] != LATER:
            break
        assert cut.memory[0] >= key
        key = cut.memory[0] + 0.1
    assert ends[-1] == status == MEETS
    assert len(ends) > 3
    assert abs(cut.memory[0] - whole.memory[0]) <= rounding_of_time(whole.memory[0], found[2])
    assert findings[0] == pytest.approx(found[0], abs=1e-12)


@pytest.mark.parametrize("scene", SCENES)
def test_a_contact_time_does_not_depend_on_where_the_query_began(scene, rng):
    """Nor on how often the flights were cut."""
    whole = two_bodies(scene)
    counts = np.zeros(COUNTS, np.int64)
    _, found = whole.query(FAR_FUTURE, counts)
    time = whole.memory[0]
    for share in rng.random(8):
        later = two_bodies(scene)
        later.memory[0] = share * time
        assert later.query(FAR_FUTURE, counts)[0] == MEETS
        assert abs(later.memory[0] - time) <= rounding_of_time(time, found[2])
        later = two_bodies(scene)
        for cut in np.sort(rng.random(3)):
            later.take_off(share * cut * time)
        assert later.query(FAR_FUTURE, counts)[0] == MEETS
        assert abs(later.memory[0] - time) <= rounding_of_time(time, found[2])
