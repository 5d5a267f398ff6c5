"""The same scene gives the same bits in every process, whatever its memory held before."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[1] / "play_and_hash.py"
SCENES = ("jam", "120", "tumble", "20", "push", "20")


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="glibc fills memory on request")
def test_nothing_is_read_that_was_not_written():
    found = {
        subprocess.run(
            [sys.executable, SCRIPT, *SCENES],
            env={**os.environ, "MALLOC_PERTURB_": filling},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for filling in ("85", "170")
    }
    assert len(found) == 1
