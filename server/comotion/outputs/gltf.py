"""An animated glTF of a run (`.glb`), which browsers, Blender and slides play: bodies by name, moved by their poses.

Format: glTF 2.0, one binary buffer. Its y axis points up, ours z: a root node turns the scene. Coordinates are float32
about the scene's `origin`, which the root's `extras` state.
"""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comotion.outputs.body_shapes import BodyShape
from comotion.outputs.picture import COLOURS

FLOAT, ARRAY_BUFFER = 5126, 34962  # glTF's numbers
Z_UP = [-(0.5**0.5), 0.0, 0.0, 0.5**0.5]  # x y z w: a quarter turn about x
MAGIC, VERSION, JSON_CHUNK, BINARY_CHUNK = 0x46546C67, 2, 0x4E4F534A, 0x004E4942


def write_glb(
    path: Path,
    shapes: Sequence[BodyShape],
    motion: Mapping[str, str],
    times: NDArray[np.float64],
    poses: NDArray[np.float64],
    scales: NDArray[np.float64],
) -> None:
    """Write shapes that take poses (times, bodies, 7), x y z [m], w qx qy qz, and scales (times, bodies), at times."""
    scene = _Scene()
    origin = np.round(poses[0, :, :3].mean(axis=0))
    kinds = list(COLOURS)
    input_times = scene.accessor((times - times[0])[:, None].astype("<f4"), "SCALAR", bounds=True)
    channels: list[dict[str, Any]] = []
    samplers: list[dict[str, Any]] = []
    nodes: list[dict[str, Any]] = []
    for row, shape in enumerate(shapes):
        places = (poses[:, row, :3] - origin).astype("<f4")
        turns = continuous(poses[:, row, 3:])[:, [1, 2, 3, 0]].astype("<f4")
        sizes = np.repeat(scales[:, row, None], 3, axis=1).astype("<f4")
        node = {"name": shape.name, "translation": places[0].tolist(), "rotation": turns[0].tolist()}
        if len(shape.corners):
            node["mesh"] = scene.mesh(shape, kinds.index(motion.get(shape.name, "free")))
        nodes.append(node)
        paths = ("translation", places, "VEC3"), ("rotation", turns, "VEC4"), ("scale", sizes, "VEC3")
        for target, values, kind in paths:
            if np.any(values != values[0]):
                channels.append({"sampler": len(samplers), "target": {"node": row, "path": target}})
                samplers.append({"input": input_times, "output": scene.accessor(values, kind)})
    root = {
        "name": "world",
        "rotation": Z_UP,
        "children": list(range(len(nodes))),
        "extras": {"origin_m": origin.tolist()},
    }
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "comotion"},
        "scene": 0,
        "scenes": [{"nodes": [len(nodes)]}],
        "nodes": [*nodes, root],
        "materials": [_material(kind) for kind in kinds],
        **({"animations": [{"name": "run", "channels": channels, "samplers": samplers}]} if channels else {}),
        **scene.lists(),
    }
    path.write_bytes(_container(document, bytes(scene.buffer)))


def continuous(quaternions: NDArray[np.float64]) -> NDArray[np.float64]:
    """The same rotations with signs such that neighbours in time are near each other: players go the short way."""
    flips = np.where(np.einsum("ij,ij->i", quaternions[1:], quaternions[:-1]) < 0.0, -1.0, 1.0)
    return quaternions * np.cumprod([1.0, *flips])[:, None]


class _Scene:
    """The buffer and the lists that point into it."""

    def __init__(self) -> None:
        self.buffer = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._meshes: list[dict[str, Any]] = []

    def accessor(self, values: NDArray[np.float32], kind: str, *, bounds: bool = False, target: bool = False) -> int:
        """Append an array; returns its number."""
        view: dict[str, Any] = {"buffer": 0, "byteOffset": len(self.buffer), "byteLength": values.nbytes}
        self._views.append(view | ({"target": ARRAY_BUFFER} if target else {}))
        self.buffer += values.tobytes()
        entry = {"bufferView": len(self._views) - 1, "componentType": FLOAT, "count": len(values), "type": kind}
        if bounds:
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        self._accessors.append(entry)
        return len(self._accessors) - 1

    def mesh(self, shape: BodyShape, material: int) -> int:
        """Append a body's mesh; returns its number."""
        attributes = {
            "POSITION": self.accessor(shape.corners, "VEC3", bounds=True, target=True),
            "NORMAL": self.accessor(shape.normals, "VEC3", target=True),
        }
        self._meshes.append({"name": shape.name, "primitives": [{"attributes": attributes, "material": material}]})
        return len(self._meshes) - 1

    def lists(self) -> dict[str, Any]:
        """What the document needs of them."""
        lists = {"bufferViews": self._views, "accessors": self._accessors, "meshes": self._meshes}
        return {"buffers": [{"byteLength": len(self.buffer)}]} | {name: rows for name, rows in lists.items() if rows}


def _material(kind: str) -> dict[str, Any]:
    srgb = [int(COLOURS[kind][place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [value**2.2 for value in srgb]
    return {
        "name": kind,
        "pbrMetallicRoughness": {"baseColorFactor": [*linear, 1.0], "metallicFactor": 0.0, "roughnessFactor": 0.8},
    }


def _container(document: dict[str, Any], binary: bytes) -> bytes:
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)

    def words(*values: int) -> bytes:
        return np.array(values, dtype="<u4").tobytes()

    return b"".join(
        [words(MAGIC, VERSION, total), words(len(text), JSON_CHUNK), text, words(len(binary), BINARY_CHUNK), binary]
    )
