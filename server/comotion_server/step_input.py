"""A step's input, refused at the door or made ready for the simulation (SPEC, section F)."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from comotion_protocol import limits
from comotion_protocol.errors import RemoteProtocolError
from comotion_protocol.messages import FloatArray, StepRequest, Sums
from comotion_server.surfaces import Surface


def check_dt(name: str, dt: float) -> float:
    """A step size [s]: positive and finite (SPEC F6)."""
    if not (math.isfinite(dt) and dt > 0.0):
        raise _refuse("bad_dt", "F6", f"{name}: expected a positive finite number of seconds, got {dt}", field=name)
    return dt


def check_step(request: StepRequest, surfaces: Mapping[str, Surface], body_count: int) -> None:
    """Refuse a step that the run cannot take."""
    check_dt("dt", request.dt)
    if request.dt_next is not None:
        check_dt("dt_next", request.dt_next)
    if request.wrenches is not None:
        if request.forces:
            raise _refuse("unknown_block", "F5", "wrenches and forces in one step: expected one of them")
        _check_array("wrenches", "F5", request.wrenches, (body_count, 6))
    for region, forces in request.forces.items():
        if region not in surfaces:
            known = ", ".join(repr(name) for name in surfaces)
            raise _refuse("unknown_region", "F2", f"forces: expected a region of {known}, got {region!r}", got=region)
        _check_array(f"forces of region {region!r}", "F3", forces, (surfaces[region].vertex_count, 3))


def _check_array(name: str, rule: str, array: FloatArray, shape: tuple[int, int]) -> None:
    if array.shape != shape:
        raise _refuse(
            "wrong_shape",
            rule,
            f"{name}: expected shape {shape}, got {array.shape}",
            expected=list(shape),
            got=list(array.shape),
        )
    if not np.isfinite(array).all():
        row, column = (int(n) for n in np.argwhere(~np.isfinite(array))[0])
        raise _refuse(
            "not_finite",
            "F4",
            f"{name}: expected finite numbers, got {array[row, column]} in row {row}, column {column}",
            row=row,
            column=column,
        )


def check_sums(request: StepRequest, found: Sums, reach: float) -> None:
    """Compare the client's sums with those found (SPEC F7); no force acts farther from the origin than `reach` [m]."""
    if request.sums is None:
        return
    force_scale, moment_scale = _scales(request, reach)
    for name, scale in (("force", force_scale), ("moment", moment_scale)):
        sent, got = np.array(getattr(request.sums, name)), np.array(getattr(found, name))
        difference = float(np.linalg.norm(sent - got))
        if difference > limits.SUMS_TOLERANCE * scale:
            raise _refuse(
                "sums_mismatch",
                "F7",
                f"sums.{name}: expected {sent.tolist()} as the client says, got {got.tolist()} from its arrays",
                expected=sent.tolist(),
                got=got.tolist(),
            )


def _scales(request: StepRequest, reach: float) -> tuple[float, float]:
    """Sums of magnitudes of force [N] and, as a bound, of moment [N m]."""
    if request.wrenches is not None:
        force = float(np.abs(request.wrenches[:, :3]).sum())
        return force, force * reach + float(np.abs(request.wrenches[:, 3:]).sum())
    force = math.fsum(float(np.abs(forces).sum()) for forces in request.forces.values())
    return force, force * reach


def _refuse(code: str, rule: str, text: str, **detail: Any) -> RemoteProtocolError:
    return RemoteProtocolError(code, rule, text, detail)
