"""The page's first message: every body's shape in its own frame, by name."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from comotion.outputs.body_shapes import BodyShape
from comotion.watching.page_message import page_message

NAME_SHOWN = 128  # characters


def scene_message(
    title: str, mode: str, shapes: Sequence[BodyShape], motion: Mapping[str, str], water_level: float | None
) -> bytes:
    """Shapes with the motion of each body ("free", "fixed", "prescribed"); `mode` is "live" or "replay"."""
    bodies: list[dict[str, Any]] = []
    corner = edge = 0
    for shape in shapes:
        bodies.append(
            {
                "name": shape.name[:NAME_SHOWN],
                "motion": motion.get(shape.name, "free"),
                "corners": [corner, len(shape.corners)],
                "edges": [edge, len(shape.edges)],
            }
        )
        corner, edge = corner + len(shape.corners), edge + len(shape.edges)
    none = [np.zeros((0, 3), "<f4")]
    arrays = {
        "corners": np.concatenate([*none, *(shape.corners for shape in shapes)]),
        "normals": np.concatenate([*none, *(shape.normals for shape in shapes)]),
        "edges": np.concatenate([*none, *(shape.edges for shape in shapes)]),
    }
    return page_message({"kind": "scene", "title": title, "mode": mode, "bodies": bodies, "water": water_level}, arrays)
