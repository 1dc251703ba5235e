"""The JSON form of scenes and motions: objects named as in Python, arrays as base64, little-endian."""

from __future__ import annotations

import base64
from dataclasses import asdict, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbody.visual.scene.scene import Scene, SceneMotion

VERSION = 1


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """Return a scene as values that `json.dumps` takes, floats with seven digits."""
    meshes = [
        {"vertices": _floats(mesh.vertices), "triangles": _encode(mesh.triangles, "<u4")}
        for mesh in scene.meshes
    ]
    return {"version": VERSION, **_rounded(asdict(replace(scene, meshes=()))), "meshes": meshes}


def motion_to_json(motion: SceneMotion) -> dict[str, Any]:
    """Return a motion as values that `json.dumps` takes; times in double, all else in single precision."""
    curves = [
        {"name": curve.name, "unit": curve.unit, "values": _floats(curve.values)} for curve in motion.curves
    ]
    vectors = [
        {"name": vector.name, "kind": vector.kind, "anchor": _rounded(asdict(vector.anchor)),
         "values": _floats(vector.values)}
        for vector in motion.vectors
    ]  # fmt: skip
    return {
        "version": VERSION,
        "times": _encode(motion.times, "<f8"),
        "positions": _floats(motion.positions),
        "quaternions": _floats(motion.quaternions),
        "curves": curves,
        "vectors": vectors,
        "events": [{"name": name, "t": t} for name, t in motion.events],
    }


def _floats(values: NDArray[np.float64]) -> str:
    return _encode(values, "<f4")


def _encode(values: NDArray[Any], kind: str) -> str:
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.7g}")
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    return value
