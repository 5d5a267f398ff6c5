"""Kernels that are chosen when they are compiled, by what shapes a scene has: what it does not have is not compiled."""

from numba.core import types
from numba.extending import overload

from comotion_server.kernels.jit import OPTIONS


def by_shapes(flat, smooth, mixed):
    """A kernel with `solids` first: one of these three, by what the scene has.

    flat: meshes and planes; smooth: no meshes; mixed: round shapes whose contact times have no closed form, or which
    stand beside meshes. `Solids.meshes` and `Solids.core` are None where there are none, a type of its own to numba.
    """

    def chosen(solids, *rest):
        kernel = mixed if solids.core is not None else smooth if solids.meshes is None else flat
        return kernel(solids, *rest)

    def choose(solids, *_):
        lacks = [isinstance(solids[solids.fields.index(name)], types.NoneType) for name in ("core", "meshes")]
        kernel = mixed if not lacks[0] else smooth if lacks[1] else flat

        def call(solids, *rest):
            return kernel(solids, *rest)

        return call

    overload(chosen, strict=False, jit_options=OPTIONS | {"_nrt": False})(choose)
    return chosen


def by_cylinders(without, beside):
    """A kernel with `solids` first: one of these two, by whether the scene has cylinders."""

    def chosen(solids, *rest):
        return (without if solids.has_cylinders is None else beside)(solids, *rest)

    def choose(solids, *_):
        lacks = isinstance(solids[solids.fields.index("has_cylinders")], types.NoneType)
        kernel = without if lacks else beside

        def call(solids, *rest):
            return kernel(solids, *rest)

        return call

    overload(chosen, strict=False, jit_options=OPTIONS | {"_nrt": False})(choose)
    return chosen
