"""The example of docs/write_your_own_client.md as it stands, and the mock, against the real server in memory."""

import functools
import re
import runpy
from pathlib import Path

import numpy as np
import pytest

from comotion_mock_cfd.cfd_client import CfdClient, wants
from comotion_mock_cfd.fluid import load_fluid
from comotion_mock_cfd.heave import HeaveRecord
from comotion_mock_cfd.scenes import path_of
from comotion_protocol import MotionClient
from comotion_protocol.link import MemoryLink
from comotion_server import Simulation
from comotion_server.desk import Desk
from comotion_server.service import Service

PAGE = Path(__file__).parents[2] / "docs" / "write_your_own_client.md"
OMEGA = np.sqrt(9.81 / 0.1)


@pytest.fixture
def served(request):
    """A shipped scene, `float_box` unless the test names another, served in memory."""
    scene = getattr(request, "param", "float_box")
    with Desk(Service(Simulation.load(path_of(scene)), scene)) as desk:
        yield MemoryLink(desk)


def test_the_example_of_the_page_runs(served, monkeypatch, capsys, tmp_path):
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(example.splitlines()) <= 36
    monkeypatch.setattr(MotionClient, "open", functools.partial(MotionClient.open, link=served))
    script = tmp_path / "my_adapter.py"
    script.write_text(example, encoding="utf-8")
    runpy.run_path(str(script))
    rows = re.findall(r"t = (\S+) s   height of the box (\S+) m   ok", capsys.readouterr().out)
    times, heights = np.array(rows, dtype=float).T
    assert len(times) == 200
    # Lift is exact while only the bottom is wet all over: a free heave of 20 mm about the level. Poses hold half a step
    # after the time printed; the midpoint scheme's phase runs ahead by (w dt)^2 / 24 of 20 rad, 0.008, of 20 mm.
    assert heights == pytest.approx(0.02 * np.cos(OMEGA * (times + 0.005)), abs=3e-4)


def test_the_mock_plays_float_box_to_its_end(served):
    scene = load_fluid(path_of("float_box"))
    with MotionClient.open("float_box", wants=wants(), dt=scene.dt, link=served) as motion:
        client = CfdClient(motion, scene)
        heave = HeaveRecord(scene, client.bodies)
        client.run(heave.add)
        assert motion.status().step == 1200
    period = heave.period()
    # The midpoint scheme's period is short by (w dt)^2 / 24 = 1e-4; drag of 0.02 of critical changes it by less.
    assert period.error == pytest.approx(0.0, abs=3e-4)
    assert heave.times[-1] == pytest.approx(6.0, abs=1e-12)


@pytest.mark.parametrize("served", ["channel"], indirect=True)
def test_rows_of_poses_are_the_bodies_in_the_order_of_their_names(served):
    with MotionClient.open("channel", wants=wants(), dt=0.005, link=served) as motion:
        bodies = CfdClient(motion, load_fluid(path_of("channel"))).bodies
        assert bodies.names == tuple(sorted(bodies.names))
        rows = zip(bodies.region_of, bodies.part_of, motion.opened.poses[:, :3], strict=True)
        for region, part, centre in rows:  # the centre of mass of a convex or slender body lies within its bounds
            vertices = motion.vertices[region][part]
            assert (vertices.min(axis=0) <= centre).all()
            assert (centre <= vertices.max(axis=0)).all()
