"""The matrix of stiff and extreme cases, but for the cells that take long: the report runs those, too."""

import pytest

from comotion.report.extreme import all_cells

CELLS = [cell for cell in all_cells() if not cell.long]


def test_the_matrix_is_wide():
    assert len(CELLS) >= 60
    names = [cell.name for cell in all_cells()]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("cell", CELLS, ids=lambda cell: cell.name)
def test_cell(cell, request):
    if cell.explained:
        request.applymarker(pytest.mark.xfail(reason=cell.explained, strict=True))
    assert cell.measure() <= cell.limit, cell.required
