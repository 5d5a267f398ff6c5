"""What a motion and a query refuse, and in which words."""

import numpy as np
import pytest

from comotion_server.geometry import Motion, MotionError, PoseError, time_of_impact
from comotion_server.meshes import box

POSE = (np.eye(3), np.zeros(3))
REFUSED = {
    "velocity must be finite": {"pose": POSE, "velocity": [np.inf, 0, 0]},
    "angular_velocity must be finite numbers of shape": {"pose": POSE, "angular_velocity": [0.0, 0.0]},
    "acceleration must be finite": {"pose": POSE, "acceleration": [np.nan, 0, 0]},
    "torque needs an inertia": {"pose": POSE, "torque": [1.0, 0, 0]},
    "inertia must be symmetric and positive definite": {"pose": POSE, "inertia": np.zeros((3, 3))},
}


@pytest.mark.parametrize(("words", "given"), REFUSED.items(), ids=REFUSED)
def test_a_motion_refuses(words, given):
    with pytest.raises(MotionError, match=words):
        Motion(**given)


@pytest.mark.parametrize("pose", [(np.eye(3),), (-np.eye(3), np.zeros(3)), (np.eye(3), [0.0, np.nan, 0.0])])
def test_a_motion_refuses_a_pose_that_is_none(pose):
    with pytest.raises(PoseError, match="pose"):
        Motion(pose)


@pytest.mark.parametrize(
    ("words", "t_max", "given"),
    [
        ("t_max must be a finite time greater than 0 s; got 0", 0.0, {}),
        ("t_max must be a finite time greater than 0 s; got nan", np.nan, {}),
        ("tolerance must be a finite length greater than 0 m; got -1", 1.0, {"tolerance": -1.0}),
        ("budget must be at least 1; got 0", 1.0, {"budget": 0}),
    ],
)
def test_a_query_refuses(words, t_max, given):
    cube = box([1.0, 1.0, 1.0])
    with pytest.raises(MotionError, match=words):
        time_of_impact(cube, Motion(POSE), cube, Motion((np.eye(3), [2.0, 0, 0])), t_max, **given)


def test_a_motion_keeps_its_own_numbers():
    velocity = np.ones(3)
    motion = Motion(POSE, velocity)
    velocity[:] = 7.0
    np.testing.assert_array_equal(motion.velocity, 1.0)
