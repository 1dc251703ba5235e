"""Model files of any format, by the end of their name."""

from __future__ import annotations

from pathlib import Path

from symbody.formats.native import load_model as load_native
from symbody.formats.urdf.building.loading import load_urdf
from symbody.model.model import Model


def load_model(path: Path) -> Model:
    """Return the model in a TOML file, or in one that ends in ``.urdf``.

    Raises
    ------
    FormatError, ModelError
        As the reader of the format.
    """
    return load_urdf(path) if path.suffix.lower() == ".urdf" else load_native(path)


def model_file(folder: Path) -> Path:
    """Return the model file of an example, which bears the name of its folder."""
    urdf = folder / f"{folder.name}.urdf"
    return urdf if urdf.is_file() else folder / f"{folder.name}.toml"
