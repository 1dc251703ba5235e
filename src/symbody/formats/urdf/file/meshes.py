"""Files of meshes: ``package://``, ``model://``, ``file://``, relative; never over the network."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Final
from urllib.request import url2pathname

from symbody.formats.urdf.file.robot import Robot, Shape

# Directories of packages, as the tools of ROS and Gazebo look for them.
_ROOTS: Final = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH", "IGN_GAZEBO_RESOURCE_PATH")
_PACKAGES: Final = ("package", "model")


def find_mesh(
    robot: Robot, shape: Shape, packages: Mapping[str, str | os.PathLike[str]] = MappingProxyType({})
) -> Path | None:
    """Return the file of a mesh, or None if the shape is not a mesh or the file is missing.

    A package is looked for in `packages`, in the directories that environment variables of ROS and Gazebo
    list, then in each directory above the robot's file. Addresses on the network lead nowhere.

    Parameters
    ----------
    packages : mapping of name to directory
    """
    scheme, mark, rest = shape.mesh.partition("://")
    folder = Path(robot.where).absolute().parent
    found: Iterable[Path]
    if not mark:
        found = [folder / shape.mesh] if shape.mesh else []
    elif scheme == "file":
        found = [Path(url2pathname(rest))]
    elif scheme in _PACKAGES:
        package, _, inside = rest.partition("/")
        found = (root / inside for root in _package_roots(package, packages, folder))
    else:
        found = []
    return next((path for path in found if _is_file(path)), None)


def _package_roots(
    package: str, packages: Mapping[str, str | os.PathLike[str]], folder: Path
) -> Iterator[Path]:
    if package in packages:
        yield Path(packages[package])
    for variable in _ROOTS:
        for root in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            yield Path(root) / package
            yield Path(root) / "share" / package
    for above in (folder, *folder.parents):
        if above.name == package:
            yield above
        yield above / package


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except (OSError, ValueError):  # a name that no file can have
        return False
