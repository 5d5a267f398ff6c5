"""Prescribed motion from a table of poses."""

import math

import numpy as np
import pytest

from comotion_server.scene import SceneError, load_scene
from comotion_server.scene.csv_table import read_pose_table

HEADER = "t,x,y,z,qw,qx,qy,qz\n"
ROUNDING = 1e-14


@pytest.fixture
def table(tmp_path):
    def table(rows, header=HEADER):
        (tmp_path / "t.csv").write_text(header + rows)
        return read_pose_table(tmp_path / "t.csv")

    return table


def about_z(angle):
    return f"{math.cos(angle / 2)!r},0,0,{math.sin(angle / 2)!r}"


def test_constant_twist_between_rows_and_rest_outside(table):
    poses = table(f"1,0,0,0,{about_z(0)}\n3,4,0,0,{about_z(1)}\n4,4,2,0,{about_z(-0.5)}\n")
    for time, velocity, spin in (
        (0.9, 0, 0),
        (1, [2, 0, 0], 0.5),
        (2.9, [2, 0, 0], 0.5),
        (3, [0, 2, 0], -1.5),
        (4, 0, 0),
        (9, 0, 0),
    ):
        found = poses.twist(time)
        np.testing.assert_allclose(found[0], np.zeros(3) + velocity, atol=ROUNDING)
        np.testing.assert_allclose(found[1], [0, 0, spin], atol=ROUNDING)
    for time, place, angle in ((0, [0, 0, 0], 0), (2, [2, 0, 0], 0.5), (3.5, [4, 1, 0], 0.25), (7, [4, 2, 0], -0.5)):
        position, quaternion = poses.pose(time)
        np.testing.assert_allclose(position, place, atol=ROUNDING)
        np.testing.assert_allclose(quaternion, [math.cos(angle / 2), 0, 0, math.sin(angle / 2)], atol=ROUNDING)


def test_twists_lead_from_row_to_row_about_any_axis(table, rng):
    quaternions = rng.normal(size=(6, 4))
    quaternions /= np.linalg.norm(quaternions, axis=1)[:, None]
    rows = "".join(f"{k},0,0,0,{','.join(map(repr, map(float, q)))}\n" for k, q in enumerate(quaternions))
    poses = table(rows)
    assert (np.einsum("ij,ij->i", poses.quaternions[1:], poses.quaternions[:-1]) > 0).all()
    for k in range(5):
        _, arrival = poses.pose(k + 1 - 1e-12)
        assert abs(arrival @ quaternions[k + 1]) == pytest.approx(1.0, abs=ROUNDING)
        assert np.linalg.norm(poses.twist(k)[1]) <= math.pi


def test_a_table_puts_its_body_where_it_is_at_time_zero(tmp_path):
    (tmp_path / "t.csv").write_text(HEADER + "-1,0,0,0,1,0,0,0\n1,4,0,0,1,0,0,0\n\n")
    (tmp_path / "s.toml").write_text(
        '[scene]\nduration = 1\ndt = 0.1\n[[body]]\nname = "a"\nshape = { box = { size = [1, 1, 1] } }\n'
        'motion = { table = "t.csv" }\n'
    )
    (body,) = load_scene(tmp_path / "s.toml").bodies
    np.testing.assert_allclose(body.position, [2, 0, 0], rtol=ROUNDING)
    np.testing.assert_allclose(body.velocity, [2, 0, 0], rtol=ROUNDING)
    assert body.motion.table.times.tolist() == [-1.0, 1.0]


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("", "t.csv:1: the header must be t,x,y,z,qw,qx,qy,qz; got ''"),
        ("t,x,y\n0,0,0\n", "t.csv:1: the header must be t,x,y,z,qw,qx,qy,qz; got 't,x,y'"),
        (HEADER, "t.csv: there is no row below the header"),
        (HEADER + "0,0,0,0,1,0,0,0\n0,0,0,0,1,0,0,0\n", "t.csv:3: t: must increase from row to row; 0 follows 0"),
        (HEADER + "0,0,0,0,1,0,0\n", "t.csv:2: must have 8 columns; got 7"),
        (HEADER + "0,0,a,0,1,0,0,0\n", "t.csv:2: y: must be a finite number; got 'a'"),
        (HEADER + "0,0,nan,0,1,0,0,0\n", "t.csv:2: y: must be a finite number; got 'nan'"),
        (HEADER + "0,0,0,0,1,1,0,0\n", "t.csv:2: qw,qx,qy,qz: must have length 1; its length is 1.41421"),
        (HEADER + "0,0,0,0,1,0,0,0\n\n1,0,0,0,0,1,0,0\n", "t.csv:4: qw,qx,qy,qz: half a turn from the row before"),
        (HEADER.encode() + b"\xff\xff", "t.csv: not a CSV file in UTF-8"),
    ],
)
def test_bad_rows_are_named(tmp_path, content, expected):
    (tmp_path / "t.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(SceneError) as refusal:
        read_pose_table(tmp_path / "t.csv")
    assert expected in str(refusal.value)


def test_all_bad_rows_at_once(table):
    with pytest.raises(SceneError) as refusal:
        table("0,0,0,0,1,0,0,x\n1,0,0,0,1,0,0\n2,0,0,0,1,0,0,0\n3,inf,0,0,1,0,0,0\n")
    assert [problem.line for problem in refusal.value.problems] == [2, 3, 5]
