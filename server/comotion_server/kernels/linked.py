"""Kernels as other kernels call them: lowered to LLVM, linked into their callers, optimised and turned into code there.

Numba optimises and emits machine code for every function it compiles, with all that the function calls, at every level
of the tree of calls. Only the kernels that Python calls need code of their own. `Entry` is a dispatcher for Python; in
a kernel its name stands for `callee`, a second dispatcher of the same function whose results are LLVM modules only.
Besides the documented `pipeline_class` this uses inner parts of numba: see `LINKED` in jit.py. A kernel must not call
itself: the machine code of a recursion is looked up in the execution engine.
"""

from functools import cached_property

from numba.core import types
from numba.core.caching import NullCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.registry import CPUDispatcher


class _Module(JITCodeLibrary):
    """The LLVM module of one kernel with those of its callees: not optimised, never given to the execution engine."""

    def _optimize_final_module(self):
        pass

    def _finalize_final_module(self):
        self._finalize_dynamic_globals()
        self._finalized = True


class _Lowering(Compiler):
    """Numba's compiler up to LLVM. The entry point of a result is a key by which callers find the module."""

    def compile_extra(self, func):
        state = self.state
        state.library = _Module(state.targetctx.codegen(), func.__qualname__)
        state.flags.no_compile = True
        result = super().compile_extra(func)._replace(entry_point=object())
        state.targetctx.insert_user_function(result.entry_point, result.fndesc, [result.library])
        return result


class _Callee(CPUDispatcher):
    def add_overload(self, cres):
        self.overloads[tuple(cres.signature.args)] = cres


class Entry(CPUDispatcher):
    """A kernel for Python to call, its machine code kept on disk; other kernels are given `callee` in its place.

    Most kernels are called by kernels alone, and once those are compiled by nobody: the file cache is looked up when
    Python first calls, in the context `keeping`, and the second dispatcher made when a caller is compiled.
    """

    def __init__(self, py_func, options, keeping):
        super().__init__(py_func, targetoptions=options)
        self._keeping = keeping

    def compile(self, sig):
        """As numba's, from the file cache where it is there."""
        if isinstance(self._cache, NullCache):
            with self._keeping():
                self.enable_caching()
        return super().compile(sig)

    @cached_property
    def callee(self):
        """What its name stands for in a kernel."""
        options = self.targetoptions | {"no_cpython_wrapper": True}
        return _Callee(self.py_func, targetoptions=options, pipeline_class=_Lowering)

    @property
    def _numba_type_(self):
        return types.Dispatcher(self.callee)
