"""The memory of a container is what its control groups leave, whatever the computer has."""

from __future__ import annotations

from pathlib import Path

import pytest

from symbody.memory import container_limits, memory_size

HUGE = 9223372036854771712  # what version 1 says where there is no limit


def written(root: Path, cgroup: str, files: dict[str, str]) -> Path:
    for name, content in {"proc/self/cgroup": cgroup, **files}.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return root


@pytest.mark.parametrize(
    ("cgroup", "files", "limits"),
    [
        # Version 2 in a container: its own group is the first.
        ("0::/\n", {"sys/fs/cgroup/memory.max": "536870912\n"}, [2**29]),
        # On a host: no limit of its own, one above it.
        ("0::/user/me\n", {"sys/fs/cgroup/user/me/memory.max": "max\n", "sys/fs/cgroup/user/memory.max": "1000\n"}, [1000]),
        # Version 1, seen from inside: the path is the host's, the files are mounted without it.
        (
            "12:cpu,cpuacct:/docker/1\n4:memory:/docker/1\n0::/\n",
            {"sys/fs/cgroup/memory/memory.limit_in_bytes": "4096\n"},
            [4096],
        ),
        ("4:memory:/\n", {"sys/fs/cgroup/memory/memory.limit_in_bytes": f"{HUGE}\n"}, [HUGE]),
        ("nonsense\n", {}, []),
    ],
)  # fmt: skip
def test_limits_of_control_groups(
    cgroup: str, files: dict[str, str], limits: list[int], tmp_path: Path
) -> None:
    assert container_limits(written(tmp_path, cgroup, files)) == limits


def test_without_control_groups_there_is_no_limit(tmp_path: Path) -> None:
    assert container_limits(tmp_path) == []
    size = memory_size()
    assert size is None or size > 2**20
