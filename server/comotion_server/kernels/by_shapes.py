"""Kernels that are chosen when they are compiled, by what shapes a scene has: what it does not have is not compiled."""

from numba.core import types
from numba.extending import overload

from comotion_server.kernels.jit import OPTIONS


def by_shapes(with_meshes, without):
    """A kernel with `solids` first: one of these two, by whether the scene has meshes.

    `Solids.meshes` is None where there are none, and None is a type of its own to numba.
    """

    def chosen(solids, *rest):
        return (without if solids.meshes is None else with_meshes)(solids, *rest)

    def choose(solids, *_):
        kernel = without if isinstance(solids[solids.fields.index("meshes")], types.NoneType) else with_meshes

        def call(solids, *rest):
            return kernel(solids, *rest)

        return call

    overload(chosen, strict=False, jit_options=OPTIONS | {"_nrt": False})(choose)
    return chosen
