"""Contact times against closed forms (VALIDATION C), at all speeds, sizes and places."""

import numpy as np
import pytest
from meshes_by_hand import tetrahedron

from comotion_server.geometry.contact_time import default_tolerance, time_of_impact
from comotion_server.geometry.motion import Motion
from comotion_server.meshes import TriangleMesh, box

HALF = np.sqrt(0.5)
TRIAXIAL = np.diag([0.7, 1.0, 0.4])
CONTACT_TIME = 1e-12  # relative: rounding of angles and coordinates, a thousand times


def about(axis, angle):
    c, s = np.cos(angle), np.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    R = np.eye(3)
    R[i, i], R[i, j], R[j, i], R[j, j] = c, -s, s, c
    return R


def scaled(mesh, factor):
    return TriangleMesh(mesh.vertices * factor, mesh.triangles)


def assert_contact(answer, time, tolerance, normal=None):
    """Never late, within the tolerance, and the extrapolated time right."""
    assert answer.status == "hit"
    assert 0.0 < answer.gap <= tolerance
    assert answer.time < time
    assert answer.safe_until == answer.time
    assert answer.contact_time == pytest.approx(time, rel=CONTACT_TIME)
    if normal is not None:
        np.testing.assert_allclose(answer.normal, normal, atol=1e-12)


ROTATIONS = {
    "held": {},
    "triaxial top": {"inertia": TRIAXIAL},
    "symmetric top": {"inertia": np.diag([0.7, 0.5, 0.5])},
}


@pytest.mark.parametrize("rotation", ROTATIONS.values(), ids=ROTATIONS)
@pytest.mark.parametrize("spin", [1e-3, 1.0, 1e5])
def test_a_rod_turns_against_an_edge(spin, rotation):
    """The long side of a rod meets an edge at P where |P| sin(phi - angle) is half its width."""
    rod, block = box([0.3, 2.0, 0.02]), box([1.0, 1.0, 1.0])
    # turning about x in the plane of y and z; the edge of the block looks at the rod that comes
    P = 0.8 * np.array([0.0, np.cos(1.0), np.sin(1.0)])
    turned = about(0, 1.0 + np.pi / 4)
    place = P + HALF * np.array([0.0, -np.sin(1.0), np.cos(1.0)])
    angle = 1.0 - np.arcsin(0.01 / 0.8)
    motion = Motion((np.eye(3), np.zeros(3)), angular_velocity=[spin, 0, 0], **rotation)
    motions = rod, motion, block, Motion((turned, place)), 2.0 / spin
    answer = time_of_impact(*motions)
    assert_contact(answer, angle / spin, default_tolerance(*motions), about(0, angle) @ [0.0, 0.0, 1.0])
    np.testing.assert_allclose(answer.point[1:], P[1:], atol=1e-8)


@pytest.mark.parametrize("rotation", ROTATIONS.values(), ids=ROTATIONS)
@pytest.mark.parametrize("spin", [1.0, 1e5])
@pytest.mark.parametrize("height", [0.55, 0.65, 0.7])
def test_a_cube_spins_into_a_plane_and_a_wall(spin, height, rotation):
    """An edge of a cube at a height comes down to it at pi/4 - acos(h sqrt 2), measured from flat."""
    cube, plane = box([1.0, 1.0, 1.0]), box([9.0, 9.0, 1.0])
    motion = Motion((np.eye(3), np.zeros(3)), angular_velocity=[spin, 0, 0], **rotation)
    time = (np.pi / 4 - np.arccos(height / HALF)) / spin
    down = cube, motion, plane, Motion((np.eye(3), [0.0, 0.0, -height - 0.5])), 2.0 / spin
    assert_contact(time_of_impact(*down), time, default_tolerance(*down), [0, 0, -1])
    wall = cube, motion, plane, Motion((about(0, np.pi / 2), [0.0, height + 0.5, 0.0])), 2.0 / spin
    time = (np.arcsin(height / HALF) - np.pi / 4) / spin
    assert_contact(time_of_impact(*wall), time, default_tolerance(*wall), [0, 1, 0])


def test_a_held_torque_turns_a_top_from_rest_against_a_plane():
    """About a principal axis: angle M t^2 / (2 I)."""
    cube, plane, height = box([1.0, 1.0, 1.0]), box([9.0, 9.0, 1.0]), 0.6
    motion = Motion((np.eye(3), np.zeros(3)), inertia=TRIAXIAL, torque=[0.05, 0.0, 0.0])
    angle = np.pi / 4 - np.arccos(height / HALF)
    case = cube, motion, plane, Motion((np.eye(3), [0.0, 0.0, -height - 0.5])), 20.0
    assert_contact(time_of_impact(*case), np.sqrt(2 * 0.7 * angle / 0.05), default_tolerance(*case), [0, 0, -1])


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e4])
@pytest.mark.parametrize("offset", [0.0, 1e6])
def test_a_fall_takes_the_root_of_two_heights_over_gravity(size, offset):
    """Face on face, and an apex on a face; of any size, and far from the world's origin."""
    place = offset * size * np.array([1.0, 0.5, -0.25])
    for mesh, low in ((box([1.0, 1.0, 1.0]), -0.5), (tetrahedron(), -0.5)):
        body, plane = scaled(mesh, size), box(size * np.array([3.0, 3.0, 1.0]))
        fall = Motion((np.eye(3), np.add(place, [0.0, 0.0, 3.0 * size])), acceleration=[0.0, 0.0, -9.81 * size])
        ground = Motion((np.eye(3), np.add(place, [0.0, 0.0, -0.5 * size])))
        case = body, fall, plane, ground, 2.0
        answer = time_of_impact(*case)
        height = fall.pose[1][2] - ground.pose[1][2] + (low - 0.5) * size
        assert_contact(answer, np.sqrt(2 * height / (9.81 * size)), default_tolerance(*case), [0, 0, -1])


def test_powers_of_two_scale_times_bit_by_bit():
    def ask(size):
        cube, plane = box([size] * 3), box([9.0 * size, 9.0 * size, size])
        R = about(0, 0.3) @ about(1, 0.4)
        motion = Motion((R, [0.0, 0.0, 3.0 * size]), [0.1 * size, 0, -size], [0.3, 0.2, 0.5])
        return time_of_impact(cube, motion, plane, Motion((np.eye(3), [0, 0, -0.5 * size])), 5.0).time

    assert ask(2.0**-20) == ask(1.0) == ask(2.0**13)


@pytest.mark.parametrize("gap", [0.3, 0.9])
def test_touching_is_a_contact_if_it_closes_and_none_if_it_opens(gap):
    """Starting within the tolerance: below the target, half of it, at once; above it, when it has come down."""
    cube, tolerance = box([1.0, 1.0, 1.0]), 1e-9
    still = Motion((np.eye(3), np.zeros(3)))
    closes = "touching" if gap < 0.5 else "hit"
    for speed, spin, status in ((-1.0, 0.0, closes), (1.0, 0.0, "none"), (1e-6, 0.0, "none"), (0.0, 0.0, "none")):
        at = (np.eye(3), [0.2, 0.1, 1.0 + gap * tolerance])
        moving = Motion(at, [0.0, 0.0, speed], [0.0, 0.0, spin])
        answer = time_of_impact(cube, still, cube, moving, 10.0, tolerance=tolerance)
        assert answer.status == status
        assert answer.safe_until == pytest.approx({"touching": 0.0, "hit": 0.4e-9, "none": 10.0}[status], abs=1e-14)


def test_an_edge_leaves_an_edge_that_it_touches_although_its_ends_dip_under_the_plane_of_contact():
    """The contact point separates at 0.01 m/s, while the turning edge sweeps through the fixed plane at once."""
    cube, tolerance = box([1.0, 1.0, 1.0]), 1e-9
    lower = Motion((about(0, np.pi / 4), np.zeros(3)))
    upper = Motion((about(1, np.pi / 4), [0.0, 0.0, 2 * HALF + 0.7 * tolerance]), [0.0, 0.0, 0.01], [0.0, 0.4, 0.7])
    answer = time_of_impact(cube, lower, cube, upper, 0.5, tolerance=tolerance)
    assert answer.status in {"hit", "none"}
    assert answer.safe_until > 1e-3
    assert answer.cost[-1] <= 30


def test_overlap_at_the_start_is_told_apart_from_contact():
    cube = box([1.0, 1.0, 1.0])
    answer = time_of_impact(cube, Motion((np.eye(3), [0, 0, 0])), cube, Motion((np.eye(3), [0.5, 0, 0])), 1.0)
    assert answer.status == "overlapping"
    assert answer.time == answer.safe_until == 0.0
    assert answer.normal is None


def test_a_used_up_budget_gives_a_proven_time_and_never_no_contact():
    cube = box([1.0, 1.0, 1.0])
    still = Motion((np.eye(3), np.zeros(3)))
    coming = Motion((about(0, 0.3), [0.0, 0.0, 4.0]), [0.0, 0.0, -1.0], [1.0, 2.0, 3.0])
    whole = time_of_impact(cube, still, cube, coming, 10.0)
    until = [time_of_impact(cube, still, cube, coming, 10.0, budget=budget) for budget in (1, 2, 4, 8)]
    assert [answer.status for answer in until] == ["budget"] * 4
    assert [answer.time for answer in until] == [None] * 4
    proven = [answer.safe_until for answer in until]
    assert proven == sorted(proven)
    assert 0.0 < proven[0] < proven[-1] <= whole.time


def test_a_landing_at_the_very_end_is_seen():
    cube = box([1.0, 1.0, 1.0])
    still, coming = Motion((np.eye(3), np.zeros(3))), Motion((np.eye(3), [0.0, 0.0, 2.0]), [0.0, 0.0, -1.0])
    assert time_of_impact(cube, still, cube, coming, 1.0).status == "hit"
    assert time_of_impact(cube, still, cube, coming, 1.0 - 1e-6).status == "none"


def test_bodies_at_rest_or_leaving_never_meet():
    cube = box([1.0, 1.0, 1.0])
    still, beside = Motion((np.eye(3), np.zeros(3))), Motion((np.eye(3), [0.0, 0.0, 1.1]))
    assert time_of_impact(cube, still, cube, beside, 1e6).status == "none"
    leaving = Motion((np.eye(3), [0.0, 0.0, 3.0]), [0.0, 0.0, 2.0])
    answer = time_of_impact(cube, still, cube, leaving, 1e6)
    assert answer.status == "none"
    assert answer.cost[0] <= 1
