"""Kernels that are chosen when they are compiled, by what shapes a scene has: what it lacks is not even imported.

They are named as "module.function" of this package.
"""

from functools import cache
from importlib import import_module

from numba.core import types
from numba.extending import overload

from comotion_server.kernels.jit import OPTIONS


def by_shapes(flat, smooth, mixed):
    """A kernel with `solids` first: one of these three, by what the scene has.

    flat: name, for meshes and planes; smooth: the kernel itself, for no meshes; mixed: name, for round shapes whose
    contact times have no closed form, or which stand beside meshes. `Solids.meshes` and `Solids.core` are None where
    there are none, a type of its own to numba.
    """

    def choose(lacks):
        return _named(mixed) if not lacks("core") else smooth if lacks("meshes") else _named(flat)

    return _chosen(choose)


def by_cylinders(without, beside):
    """A kernel with `solids` first: `without` itself, or `beside`, a name, by whether the scene has cylinders."""

    def choose(lacks):
        return without if lacks("has_cylinders") else _named(beside)

    return _chosen(choose)


@cache
def _named(name):
    module, function = name.split(".")
    return getattr(import_module(f"comotion_server.kernels.{module}"), function)


def _chosen(choose):
    """A function of `solids` and the rest that numba replaces by the kernel that is chosen when it is compiled."""

    def chosen(solids, *rest):
        return choose(lambda name: getattr(solids, name) is None)(solids, *rest)

    def chosen_by_types(solids, *_):
        kernel = choose(lambda name: isinstance(solids[solids.fields.index(name)], types.NoneType))

        def call(solids, *rest):
            return kernel(solids, *rest)

        return call

    overload(chosen, strict=False, jit_options=OPTIONS | {"_nrt": False})(chosen_by_types)
    return chosen
