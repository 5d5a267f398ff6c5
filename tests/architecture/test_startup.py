"""Start-up is a feature: help answers at once, because heavy libraries are imported only where they are used."""

import json
import subprocess
import sys

import pytest

HEAVY = (
    "numpy",
    "numba",
    "trimesh",
    "pydantic",
    "zenoh",
    "msgpack",
    "matplotlib",
    "h5py",
    "pyvista",
    "vtk",
    "rich",
    "shtab",
    "PIL",
    "websockets",
)


def loaded_by(code):
    """Which heavy libraries a fresh interpreter has loaded after running some code."""
    report = f"import sys, json\n{code}\nprint(json.dumps(sorted(set(sys.modules) & set({HEAVY!r}))))"
    done = subprocess.run([sys.executable, "-c", report], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["rnu"], ["run", "drop", "--dt", "0"]])
def test_the_command_line_itself_loads_nothing_heavy(arguments):
    code = (
        f"import contextlib\nfrom comotion.main import main\nwith contextlib.suppress(SystemExit): main({arguments!r})"
    )
    assert loaded_by(code) == set()


@pytest.mark.parametrize("package", ["comotion", "comotion_server", "comotion_server.kernels", "comotion_protocol"])
def test_packages_load_nothing_heavy_by_themselves(package):
    assert loaded_by(f"import {package}") == set()


def test_a_client_needs_only_the_base_install():
    loaded = loaded_by("from comotion_protocol import MotionClient\nimport comotion_protocol.zenoh_link")
    assert loaded == {"numpy", "msgpack", "zenoh"}


def test_the_mock_needs_neither_numba_nor_trimesh():
    code = "from comotion.commands import play\nfrom comotion import fluid_scene"
    assert loaded_by(code).isdisjoint({"numba", "trimesh", "matplotlib", "h5py", "pyvista", "shtab"})


def test_a_plan_compiles_nothing():
    code = "from comotion.main import main\nmain(['plan', 'float_box'])"
    assert loaded_by(code).isdisjoint({"zenoh", "matplotlib", "h5py", "pyvista"})
