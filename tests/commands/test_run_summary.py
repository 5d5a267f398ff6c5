"""What a run tells at its end, from replies made by hand."""

import argparse
import csv
import json
from types import SimpleNamespace

import numpy as np
import pytest

from comotion.commands.play import tell
from comotion.outputs.tables import Tables
from comotion.run_record import RunRecord
from comotion.summary import Summary
from comotion_protocol import messages as m

BOOKS = {"momentum": 0.0, "angular_momentum": 0.0, "energy": 0.0, "overlaps": 0, "overlap_max": 0.0, "impacts": 2}
PAIRS = (m.Pair(body_a="bank", body_b="floe-2"), m.Pair(body_a="floe-2", body_b="hull"))


def step(time, *, blocked=(), **budget):
    """One step as the mock client records it."""
    reply = m.StepReply(
        step=1,
        attempt=0,
        time=time,
        dt=0.5,
        sample_time=time,
        status="blocked" if blocked else "ok",
        sums=m.Sums(force=(0.0, 0.0, 0.0), moment=(0.0, 0.0, 0.0)),
        budget=m.Budget(limit=10, used=2, exhausted=False, **budget),
        books=m.Books(**BOOKS, rest_energy=0.25, shift_work=-0.125),
        blocked=blocked or None,
    )
    return SimpleNamespace(step=1, time=time, dt=0.5, wrenches=np.zeros((3, 6)), reply=reply)


@pytest.fixture
def blocked_summary():
    record = RunRecord(start=0.0, time=0.0)
    record.add(step(0.5))
    record.add(step(1.0, blocked=(m.Blocked(time=0.75, bodies=("hull",), contacts=PAIRS),), capped=3, fallback=0.5))
    record.add(step(1.5, blocked=(m.Blocked(time=1.0, bodies=("hull",), contacts=PAIRS),)))
    return Summary("jam", record, wall_time=3.0, protocol_share=0.1, heave=None)


def test_a_blocked_run_names_who_was_blocked(blocked_summary):
    lines = blocked_summary.lines()
    assert lines[0].endswith("jam: blocked")
    at = next(k for k, line in enumerate(lines) if line.startswith("blocked"))
    assert [line.strip() for line in lines[at : at + 3]] == [
        "blocked         2 steps, first at 1 s",
        "kept in place: hull",
        "no way between: bank and floe-2, floe-2 and hull",
    ]
    assert any("3 impacts did not end" in line for line in lines)
    assert any("held by time-stepping in 1 steps" in line for line in lines)


def test_a_blocked_run_ends_with_exit_code_1(blocked_summary, capsys):
    assert tell(blocked_summary, argparse.Namespace(json=True)) == 1
    data = json.loads(capsys.readouterr().out)
    assert (data["status"], data["blocked_at_s"], data["blocked_bodies"]) == ("blocked", [1.0, 1.5], ["hull"])
    assert data["blocked_contacts"] == [["bank", "floe-2"], ["floe-2", "hull"]]
    assert (data["rest_energy_J"], data["shift_work_J"], data["impacts"]) == (0.75, -0.375, 6)


def test_long_lists_of_names_are_cut(blocked_summary):
    blocked_summary.record.blocked_bodies.update(f"floe-{k:03d}" for k in range(20))
    assert any(line.strip().endswith("floe-005 and 15 more") for line in blocked_summary.lines())


def test_friction_and_held_contacts_are_in_the_tables(tmp_path):
    tables = Tables(tmp_path)
    impact = m.Impact(
        time=0.5,
        body_a="a",
        body_b="b",
        point=(0.0, 0.0, 0.0),
        normal=(0.0, 0.0, 1.0),
        impulse=2.0,
        approach_speed=1.0,
        restitution=0.0,
        law="together",
        friction=(0.5, 0.25, 0.0),
    )
    contact = m.Contact(body_a="a", body_b="b", impulse=(0.5, 0.25, 3.0), count=1, held=(0.0, 0.0, 1.0))
    without = m.Contact(body_a="a", body_b="c", impulse=(1.0, 0.0, 0.0), count=1)
    tables.write_impacts([impact])
    tables.write_contacts(0.5, [contact, without])
    tables.close()
    (row,) = csv.DictReader((tmp_path / "impacts.csv").read_text().splitlines())
    assert [row[f"friction_{axis} [N s]"] for axis in "xyz"] == ["0.5", "0.25", "0.0"]
    rows = list(csv.DictReader((tmp_path / "contacts.csv").read_text().splitlines()))
    assert [row["held_z [N s]"] for row in rows] == ["1.0", "0.0"]
