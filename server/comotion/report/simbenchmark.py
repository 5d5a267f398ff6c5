"""Published points of SimBenchmark (D. Kang, J. Hwangbo): bouncing and elastic 666 test, on its authors' machine.

From data/bouncing/sample.csv and data/666-elastic/sample.csv of github.com/leggedrobotics/SimBenchmark, commit
072d4d4e4a7395c7bdd66a66fc381f06919868e7: without error reduction, first solver of each engine. A row there is the step
[s], the mean of the squared error of the energy [J2], and the processor's time for the whole run [s]; the durations are
those of its sources (BouncingBenchmark.hpp, Elastic666Benchmark.hpp).
"""

from math import sqrt

from comotion.report.findings import Curve, Point

SOURCE = "https://github.com/leggedrobotics/SimBenchmark"
G, MASS = 9.81, 10.0  # [m/s2], [kg] of a ball
DURATION = {"balls49": 20.0, "balls216": 10.0}  # [s]
ENERGY = {
    "balls49": 49 * MASS * G * 5.0,  # [J] at the start, above the ground
    "balls216": 216 * MASS * G * (1.101 + 2.5 * 0.21 + 0.0005),  # the last: mean of the perturbation
}
ROWS: dict[str, dict[str, tuple[tuple[float, float, float], ...]]] = {
    "balls49": {
        "RaiSim": (
            (0.1, 1.83452e6, 0.00284791),
            (0.04, 47390.6, 0.00706506),
            (0.01, 185.953, 0.0252268),
            (0.004, 4.76468, 0.0589612),
            (0.001, 0.0186204, 0.223834),
            (0.0004, 4.77103e-4, 0.584519),
            (0.0001, 1.86413e-6, 2.35982),
            (0.00004, 4.77199e-8, 5.80092),
            (0.00001, 1.86445e-10, 22.756),
        ),
        "ODE": (
            (0.1, 2.03326e6, 0.0205591),
            (0.04, 313419.0, 0.0479541),
            (0.01, 18808.3, 0.188425),
            (0.004, 2982.68, 0.474593),
            (0.001, 185.027, 1.85601),
            (0.0004, 29.631, 4.6723),
            (0.0001, 1.85055, 19.7783),
            (0.00004, 0.296044, 46.208),
            (0.00001, 0.0185024, 195.802),
        ),
        "Bullet (2018)": (
            (0.1, 7.67704e8, 0.0160391),
            (0.04, 1.19223e8, 0.0310302),
            (0.01, 7.40664e6, 0.102335),
            (0.004, 1.20178e6, 0.226891),
            (0.001, 75245.4, 0.851648),
            (0.0004, 12038.5, 2.07987),
            (0.0001, 752.345, 8.22547),
            (0.00004, 120.372, 20.5228),
            (0.00001, 7.52322, 81.2018),
        ),
    },
    "balls216": {
        "RaiSim": (
            (0.1, 1.19339e8, 0.0177169),
            (0.04, 2.73152e9, 0.0230181),
            (0.01, 5.18417e6, 0.073359),
            (0.004, 264.072, 0.185751),
            (0.001, 8.36835, 0.681546),
            (0.0004, 0.248699, 1.67978),
            (0.0001, 0.00110304, 6.62548),
        ),
        "ODE": (
            (0.1, 2.09881e7, 0.096046),
            (0.05, 1.11726e6, 0.120441),
            (0.01, 8.56018e6, 0.580998),
            (0.004, 1649.17, 1.43329),
            (0.001, 112.326, 5.59659),
            (0.0004, 17.506, 13.7719),
            (0.0001, 1.0958, 56.2281),
        ),
        "Bullet (2018)": (
            (0.1, 1.72019e9, 0.150474),
            (0.05, 1.05315e8, 0.149203),
            (0.01, 9.86396e6, 0.31976),
            (0.004, 840066.0, 0.65147),
            (0.001, 41498.1, 2.31772),
            (0.0004, 3563.92, 5.93753),
            (0.0001, 167.526, 21.5038),
        ),
    },
}
NOTE = (
    f"Curves named `published`: SimBenchmark by D. Kang and J. Hwangbo ({SOURCE}, data/, commit 072d4d4), without error"
    " reduction, on its authors' machine of 2018: their times compare with each other, and with ours only roughly. Its"
    " mean squared errors [J2] are shown as their root over the energy at the start."
)


def published(case: str) -> list[Curve]:
    """The curves of a case; none where nothing is published."""
    return [
        Curve(
            f"{engine}, published",
            "dt [s]",
            [Point(spent / DURATION[case], sqrt(square) / ENERGY[case], f"{dt:g}") for dt, square, spent in rows],
        )
        for engine, rows in ROWS.get(case, {}).items()
    ]
