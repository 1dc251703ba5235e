"""Model files of any format, by the end of their name, and the examples."""

from __future__ import annotations

from pathlib import Path

from symbody.errors import EnvironmentFault, Problem
from symbody.formats.native import load_model as load_native
from symbody.formats.urdf.building.loading import load_urdf
from symbody.model.model import Model


def load_model(path: Path) -> Model:
    """Return the model in a TOML file, or in one that ends in ``.urdf``; faults are those of its reader."""
    return load_urdf(path) if path.suffix.lower() == ".urdf" else load_native(path)


def examples_folder() -> Path:
    """Return the folder of the examples, installed or beside the sources; an EnvironmentFault if none."""
    package = Path(__file__).parents[1]
    for folder in (package / "examples", package.parents[1] / "examples"):
        if folder.is_dir():
            return folder
    what = "the examples are not installed"
    raise EnvironmentFault(Problem("cli.no_examples", str(package), what, "", "install symbody again"))


def model_file(folder: Path) -> Path:
    """Return the model file of an example, which bears the name of its folder."""
    urdf = folder / f"{folder.name}.urdf"
    return urdf if urdf.is_file() else folder / f"{folder.name}.toml"


def example_names(folder: Path) -> list[str]:
    """Return the examples, folders with a script of the same name: ``slider_crank``, ``notes/basics``."""
    scripts = [*folder.glob("*/*.py"), *folder.glob("*/*/*.py")]
    found = (path.parent.relative_to(folder).as_posix() for path in scripts if path.stem == path.parent.name)
    return sorted(found, key=lambda name: ("/" in name, name))


def example_text(folder: Path) -> str:
    """Return the model file of an example, or its script where it has none."""
    model = model_file(folder)
    chosen = model if model.is_file() else folder / f"{folder.name}.py"
    return chosen.read_text(encoding="utf-8")
