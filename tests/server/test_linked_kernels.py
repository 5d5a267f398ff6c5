"""Machine code is made of the kernels that Python calls, and of no kernel that only they call."""

import os
import subprocess
import sys

import numpy as np
import pytest

from comotion_server.kernels.jit import LINKED, jit, lean_jit
from comotion_server.kernels.rotation import rotate_left


@lean_jit
def scaled(x, factor):
    return factor * x


@jit
def first_above(values, least):
    for i in range(len(values)):
        if scaled(values[i], 2.0) > least:
            return i
    return -1


@jit
def counted(values):
    found = np.zeros(len(values), dtype=np.int64)
    for i in range(len(values)):
        found[i] = first_above(values, values[i])
    return found


@jit
def refusing(x):
    if x > 1.0:
        raise ValueError("too large")
    return x


@jit
def asking(x):
    return refusing(2.0 * x)


def test_the_pinned_numba_links():
    assert LINKED


def test_an_error_of_a_callee_reaches_python():
    assert asking(0.25) == 0.5
    with pytest.raises(ValueError, match="too large"):
        asking(3.0)


OTHER_NUMBA = """
import numba
numba.__version__ = "0.0.0"
import numpy as np
from comotion_server.kernels.jit import LINKED
from comotion_server.kernels.rotation import rotate_left
R = np.eye(3)
rotate_left(R, 0.1, 0.2, 0.3)
print(LINKED, type(rotate_left).__name__, R.tobytes().hex())
"""


def test_with_another_numba_every_kernel_is_compiled_by_itself_and_gives_the_same_bits():
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", OTHER_NUMBA]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    R = np.eye(3)
    rotate_left(R, 0.1, 0.2, 0.3)
    assert done.stdout.split() == ["False", "CPUDispatcher", R.tobytes().hex()]
