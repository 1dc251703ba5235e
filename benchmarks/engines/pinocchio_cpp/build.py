"""The program that times Pinocchio in C++: built once, kept in a folder of its own.

Headers and libraries are those of the Python package `pin`, Eigen that of the system. Nothing is built unless
asked for; building takes minutes and about 3 GB of memory.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from typing import Final

SOURCE: Final = Path(__file__).with_name("pinocchio_calls.cpp")
FLAGS: Final = (
    "-O3",
    "-march=native",
    "-DNDEBUG",
    "-std=c++17",
    "-w",
    # Joints of Pinocchio are a boost::variant of more types than Boost's default lists hold.
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
EIGEN: Final = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")
VARIABLE: Final = "SYMBODY_BENCHMARKS"


def program() -> tuple[Path | None, str]:
    """Return the program, built if it is not there yet, or None and why there is none."""
    found, command = _command()
    if command is None or found.is_file():
        return (found, "") if command is not None else (None, _MISSING)
    found.parent.mkdir(parents=True, exist_ok=True)
    print(f"building {found}: takes some minutes, once", flush=True)
    half_done = found.with_suffix(f".{os.getpid()}")
    done = subprocess.run([*command, "-o", str(half_done)], capture_output=True, text=True)
    if done.returncode:
        return None, f"Pinocchio's program does not compile: {done.stderr.strip().splitlines()[-1]}"
    half_done.replace(found)
    return found, ""


_MISSING: Final = (
    "Pinocchio in C++ is left out: it needs the package pin, Eigen's headers, and g++ or clang++"
)


def _command() -> tuple[Path, list[str] | None]:
    """Return where the program is kept and the command that compiles it, None where something lacks."""
    prefix = Path(sysconfig.get_path("purelib"), "cmeel.prefix")
    compiler = shutil.which(os.environ.get("CXX", "")) or shutil.which("g++") or shutil.which("clang++")
    eigen = next((folder for folder in EIGEN if Path(folder).is_dir()), None)
    config = prefix / "include" / "pinocchio" / "config.hpp"
    text = SOURCE.read_bytes() + " ".join(FLAGS).encode() + str(prefix).encode()
    if config.is_file():
        text += config.read_bytes()
    kept = Path(os.environ.get(VARIABLE, "") or Path.home() / ".cache" / "symbody_benchmarks")
    found = kept / f"pinocchio_calls_{hashlib.sha256(text).hexdigest()[:12]}"
    if compiler is None or eigen is None or not config.is_file():
        return found, None
    paths = ["-I", str(prefix / "include"), "-I", eigen, "-L", str(prefix / "lib")]
    boost = sorted((prefix / "lib").glob("libboost_serialization.so*"))
    libraries = [str(boost[0])] if boost else ["-lboost_serialization"]
    return found, [compiler, *FLAGS, *paths, str(SOURCE), *libraries, f"-Wl,-rpath,{prefix / 'lib'}"]
