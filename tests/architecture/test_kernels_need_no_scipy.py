"""Kernels use no matrix products of numpy: numba makes BLAS calls of SciPy of them, which a server does not install."""

import ast
from pathlib import Path

import pytest

import comotion_server.kernels

KERNELS = sorted(Path(comotion_server.kernels.__file__).parent.glob("*.py"))
BLAS_NAMES = {"dot", "vdot", "matmul", "inner", "linalg"}  # of numpy; our own functions are called without `np.`


def blas_lines(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp | ast.AugAssign) and isinstance(node.op, ast.MatMult):
            yield node.lineno
        if isinstance(node, ast.Attribute) and node.attr in BLAS_NAMES:
            yield node.lineno


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda path: path.stem)
def test_kernel_has_no_blas_call(kernel):
    assert list(blas_lines(ast.parse(kernel.read_text()))) == []
