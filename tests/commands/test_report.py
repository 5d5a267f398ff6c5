"""`comotion report`: what it writes, and what it refuses."""

import json
from dataclasses import replace

import pytest

from comotion.commands.errors import BAD_OUTCOME
from comotion.main import main
from comotion.report.findings import Chart, Curve, Findings, Point, Table
from comotion.report.pages import Run, write_index, write_study
from comotion.report.study import STUDIES

MACHINE = {"processor": "p", "cores": 2, "load_at_start": 0.0, "system": "s", "python": "3", "libraries": {}}
RUN = Run("2020-01-01", MACHINE, 1.0, None, quick=False)


def test_a_quick_report_writes_pages_tables_and_figures(tmp_path, capsys):
    names = ["contact_time", "staircase"]
    assert main(["report", *names, "--quick", "--json", "--out", str(tmp_path)]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [(study["study"], study["error"]) for study in told["studies"]] == [(name, None) for name in names]
    for name in names:
        assert {path.suffix for path in tmp_path.glob(f"{name}*")} == {".json", ".md", ".png", ".svg"}
        (chart,) = json.loads((tmp_path / f"{name}.json").read_text())["charts"]
        exact = next(curve for curve in chart["curves"] if curve["name"] == "exact")
        assert exact["points"]
        assert max(point["y"] for point in exact["points"]) < 1e-7
    assert "--quick" in (tmp_path / "README.md").read_text()


def test_an_unknown_study_is_refused_by_name(capsys):
    assert main(["report", "atitude"]) == 2
    assert "did you mean 'attitude'" in capsys.readouterr().err


def test_every_study_has_a_module_of_its_name():
    from importlib.util import find_spec

    assert all(find_spec(f"comotion.report.{study.name}") for study in STUDIES)


def test_a_slope_is_that_of_the_power_law():
    curve = Curve("c", "n", [Point(float(x), 3.0 * x**-4, "") for x in (1, 2, 4, 8)])
    assert curve.slope() == pytest.approx(-4.0, abs=1e-12)
    curve.points.append(Point(1e6, 1e-17, ""))  # rounding is not fitted
    assert curve.slope() == pytest.approx(-4.0, abs=1e-12)


def test_what_json_does_not_have_is_written_as_text(tmp_path):
    chart = Chart("x", "t", "x", "y", [Curve("c", "n", [Point(1.0, float("inf"), "1")])])
    write_study(STUDIES[0], Findings([chart], [Table("t", ["a"], [[None], [True]])]), RUN, tmp_path)
    data = json.loads((tmp_path / f"{STUDIES[0].name}.json").read_text())
    assert data["charts"][0]["curves"][0]["points"][0]["y"] == "inf"
    write_index(tmp_path)
    assert STUDIES[0].title in (tmp_path / "README.md").read_text()


def test_a_study_that_fails_is_reported_and_the_next_one_runs(tmp_path, monkeypatch, capsys):
    def study(**_):
        raise ValueError("no answer")

    monkeypatch.setattr("comotion.report.attitude.study", study)
    assert main(["report", "attitude", "staircase", "--quick", "--out", str(tmp_path)]) == BAD_OUTCOME
    assert "ValueError: no answer" in capsys.readouterr().out
    index = (tmp_path / "README.md").read_text()
    assert "failed: ValueError: no answer" in index
    assert "(staircase.md) | done" in index


def test_studies_of_other_runs_stay_in_the_folder(tmp_path):
    for study, day in zip(STUDIES[:2], ("2020-01-01", "2020-02-02"), strict=True):
        write_study(study, Findings(), replace(RUN, day=day), tmp_path)
        write_index(tmp_path)
    index = (tmp_path / "README.md").read_text()
    assert all(word in index for word in (STUDIES[0].title, STUDIES[1].title, "2020-01-01", "2020-02-02"))
