"""How much memory this process may take: that of the computer, or less in a container."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path, PurePosixPath
from typing import Final

from symbody.single_flight import once

_ROOT: Final = Path("/")


@once
def memory_size() -> int | None:
    """Return the bytes of memory of this computer, or of the container if that has fewer; None: not known."""
    sizes = container_limits(_ROOT)
    with suppress(AttributeError, OSError, ValueError):  # no such question on this system
        sizes.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(sizes, default=None)


def container_limits(root: Path) -> list[int]:
    """Return the limits of the control groups that this process is in, and of those above them.

    Linux's versions 1 and 2 (cgroups(7)); in a container the groups are mounted as if its own were the first.

    Parameters
    ----------
    root : Path
        Where ``proc`` and ``sys`` lie.
    """
    limits: list[int] = []
    with suppress(OSError, ValueError):
        for line in (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines():
            _, controllers, place = line.split(":", 2)
            if controllers == "":
                base, name = root / "sys/fs/cgroup", "memory.max"
            elif "memory" in controllers.split(","):
                base, name = root / "sys/fs/cgroup/memory", "memory.limit_in_bytes"
            else:
                continue
            group = PurePosixPath(place.lstrip("/"))
            for folder in (group, *group.parents):
                with suppress(OSError, ValueError):  # not mounted here, or "max"
                    limits.append(int((base / folder / name).read_text(encoding="ascii")))
    return limits
