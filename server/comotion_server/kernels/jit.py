"""The one jit decorator of the kernels.

Numba's file cache notices an edit of the decorated function's own file only: a cached caller in another file goes on
running the old callee. So the cache folder is named by the hash of *all* kernel sources (and of numba's version): any
edit starts a fresh folder, and several processes may start at once.
"""

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numba


def _sources_hash() -> str:
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(source.name.encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    base = os.environ.get("COMOTION_CACHE") or os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    folder = Path(base) / "comotion" / f"kernels-{_sources_hash()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.mkdtemp(prefix="comotion-kernels-"))  # private: a cache file is code
    return folder


CACHE_FOLDER = _cache_folder()
OPTIONS = {"error_model": "numpy", "nogil": True, "no_cfunc_wrapper": True}
CONFIG: Any = numba.config  # numba fills it while it runs: no type knows its fields
KNOWN = numba.__version__.startswith("0.68.")  # linked.py uses inner parts of numba
LINKED = KNOWN and not CONFIG.DISABLE_JIT

if LINKED:
    from comotion_server.kernels.linked import Entry


@contextmanager
def _in_cache_folder() -> Iterator[None]:
    before = CONFIG.CACHE_DIR
    CONFIG.CACHE_DIR = str(CACHE_FOLDER)
    try:
        yield
    finally:
        CONFIG.CACHE_DIR = before


def jit(function, *, _nrt=True):
    """Compile on first use, in nopython mode, cached, without fast-math (bounds and distances need IEEE rules).

    Machine code is made only of kernels that Python calls (linked.py); another numba makes it of all of them.
    """
    options = OPTIONS | {"_nrt": _nrt}
    if LINKED:
        return Entry(function, options | {"nopython": True, "boundscheck": None}, _in_cache_folder)
    with _in_cache_folder():
        return numba.njit(cache=True, **options)(function)


def lean_jit(function):
    """As `jit`, for kernels that make no arrays: without the counting of references to those they are given.

    A count is an atomic operation per array and call, and a bundle has many arrays: where little is computed at a time,
    counting costs several times what the arithmetic does. The caller holds the arrays meanwhile.
    """
    return jit(function, _nrt=False)
