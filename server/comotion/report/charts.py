"""Draws charts as PNG and SVG; the only file that needs matplotlib."""

from math import isfinite
from pathlib import Path
from textwrap import fill

from comotion.report.findings import Chart

MARKS = ("o-", "s--", "^--", "v--", "D--", "P--", "X--", "*--")
TITLE_WIDTH = 80  # characters
LOWEST = 1e-17  # an error of zero is drawn here


def draw(chart: Chart, folder: Path) -> list[Path]:
    """One figure: a curve per method, the parameter at its ends, the rounding floor."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with rc_context({"svg.hashsalt": "comotion", "font.size": 9}):
        figure = Figure(figsize=(7.0, 5.0), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        for k, curve in enumerate(chart.curves):
            points = [p for p in curve.points if isfinite(p.y) and isfinite(p.x)]
            slope = curve.slope()
            power = "" if slope is None else f", slope {slope:.1f}"
            ys = [max(p.y, LOWEST) for p in points]
            axes.loglog(
                [p.x for p in points], ys, MARKS[k % len(MARKS)], label=f"{curve.name} ({curve.parameter}{power})"
            )
            for point, y in list(zip(points, ys, strict=True))[:: max(len(points) - 1, 1)]:  # the first and the last
                axes.annotate(point.label, (point.x, y), xytext=(3, 3), textcoords="offset points", fontsize=7)
        if chart.floor is not None:
            axes.axhline(chart.floor, color="grey", linestyle=":", label="rounding")
        axes.set_title(fill(chart.title, TITLE_WIDTH))
        axes.set_xlabel(chart.x_label)
        axes.set_ylabel(chart.y_label)
        axes.grid(alpha=0.3)
        axes.legend(fontsize=7)
        paths = [folder / f"{chart.name}.{kind}" for kind in ("png", "svg")]
        figure.savefig(paths[0], dpi=120)
        figure.savefig(paths[1], metadata={"Date": None})
    return paths
