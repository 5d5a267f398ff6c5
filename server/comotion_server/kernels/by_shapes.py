"""Kernels that are chosen when they are compiled, by what shapes a scene has: what it does not have is not compiled.

`Solids.meshes` and `Solids.curves` are arrays or None, and None is another type to numba.
"""

from comotion_server.kernels.jit import OPTIONS
from numba.core import types
from numba.extending import overload


def by_shapes(with_meshes, with_curves, smooth):
    """A kernel with `solids` first: one of these three, which take the same.

    with_meshes: the scene has meshes, and may have any other shape; with_curves: none, but pairs whose contact times
    have no closed form; smooth: none of these.
    """

    def chosen(solids, *rest):
        if solids.meshes is not None:
            return with_meshes(solids, *rest)
        return (smooth if solids.curves is None else with_curves)(solids, *rest)

    def choose(solids, *rest):
        missing = [isinstance(solids[solids.fields.index(name)], types.NoneType) for name in ("meshes", "curves")]
        kernel = with_meshes if not missing[0] else smooth if missing[1] else with_curves

        def call(solids, *rest):
            return kernel(solids, *rest)

        return call

    overload(chosen, strict=False, jit_options=OPTIONS | {"_nrt": False})(choose)
    return chosen
