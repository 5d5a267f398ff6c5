"""Bodies that begin in the bore of a pipe and are too large for it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from comotion_server.quaternions import rotation_from_quaternion
from comotion_server.scene.curved_shapes import Capsule, Cylinder, Pipe, Sphere

if TYPE_CHECKING:
    from collections.abc import Iterator

    from comotion_server.scene.bodies import MadeBody
    from comotion_server.scene.toml_lines import Path as Keys


def too_large_for_pipes(made: list[MadeBody]) -> Iterator[tuple[Keys, str]]:
    """Where the radius of such a body is given, and what is wrong with it; one member stands for an array."""
    blamed: set[Keys] = set()
    pipes = [(item, item.body.shape) for item in made if isinstance(item.body.shape, Pipe)]
    for item in made if pipes else ():
        shape = item.body.shape
        if not isinstance(shape, Sphere | Capsule | Cylinder) or item.keys in blamed:
            continue
        for pipe, around in pipes:
            if shape.radius > around.inner_radius and _is_in_bore(item, pipe, around):
                blamed.add(item.keys)
                where = f'body "{item.body.name}" begins in the bore of the pipe "{pipe.body.name}"'
                limit = f"must be at most its inner radius, {around.inner_radius:g} m"
                yield (*item.keys, "shape", shape.kind, "radius"), f"{limit}: {where}; got {shape.radius:g}"
                break


def _is_in_bore(item: MadeBody, pipe: MadeBody, around: Pipe) -> bool:
    """Whether the centre of a body lies in the bore of a pipe."""
    offset = rotation_from_quaternion(pipe.body.quaternion).T @ (item.body.position - pipe.body.position)
    across = np.delete(offset, around.axis)
    return bool(abs(offset[around.axis]) < 0.5 * around.length and np.hypot(*across) < around.inner_radius)
