"""The JSON form of scenes and motions: objects named as in Python, arrays as base64, little-endian."""

from __future__ import annotations

import base64
from dataclasses import is_dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from symbody.visual.scene.scene import Scene, SceneMotion

VERSION = 1


def scene_to_json(scene: Scene) -> dict[str, Any]:
    """Return a scene as values that `json.dumps` takes, floats with seven digits."""
    meshes = [
        {"vertices": encode_array(mesh.vertices), "triangles": encode_array(mesh.triangles, "<u4")}
        for mesh in scene.meshes
    ]
    return {"version": VERSION, **_round(replace(scene, meshes=())), "meshes": meshes}


def motion_to_json(motion: SceneMotion) -> dict[str, Any]:
    """Return a motion as values that `json.dumps` takes; times in double, all else in single precision."""
    curves = [
        {"name": curve.name, "unit": curve.unit, "values": encode_array(curve.values)}
        for curve in motion.curves
    ]
    vectors = [
        {"name": vector.name, "kind": vector.kind, "anchor": _round(vector.anchor),
         "values": encode_array(vector.values),
         "places": None if vector.places is None else encode_array(vector.places),
         "prints": True if vector.prints else None}
        for vector in motion.vectors
    ]  # fmt: skip
    return {
        "version": VERSION,
        "times": encode_array(motion.times, "<f8"),
        "positions": encode_array(motion.positions),
        "quaternions": encode_array(motion.quaternions),
        "curves": curves,
        "vectors": vectors,
        "events": [{"name": name, "t": t} for name, t in motion.events],
    }


def encode_array(values: ArrayLike, kind: str = "<f4") -> str:
    """Return an array as the pages decode it: base64 of little-endian numbers, in single precision."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode("ascii")


def _round(value: Any) -> Any:
    """Return dataclasses as mappings, sequences as lists, and floats with seven digits."""
    if isinstance(value, float):
        return float(f"{value:.7g}")
    if isinstance(value, tuple | list):
        return [_round(each) for each in value]
    if isinstance(value, str | int | None):  # most of what is left: sooner than a look for fields
        return value
    if is_dataclass(value):
        return {name: _round(getattr(value, name)) for name in value.__dataclass_fields__}
    return value
