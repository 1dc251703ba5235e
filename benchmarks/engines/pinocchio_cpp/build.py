"""The programs with Pinocchio in C++: built once, kept in a folder of their own.

Headers and libraries are those of the Python packages `pin` and `casadi`; Eigen is the system's, or the one
that comes with `casadi`. Nothing is built unless asked for; building takes minutes and 3 to 4 GB of memory.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sysconfig
from pathlib import Path
from typing import Final

from benchmarks.engines.call_loops.loops import kept_folder

CALLS, GENERATE = "calls", "generate"
FLAGS: Final = (
    "-std=c++17",
    "-w",
    # Joints of Pinocchio are a boost::variant of more types than Boost's default lists hold.
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
# What is timed is compiled for speed; what writes C is only compiled.
OPTIMIZED: Final = {CALLS: ("-O3", "-march=native", "-DNDEBUG"), GENERATE: ("-O1",)}
EIGEN: Final = ("/usr/include/eigen3", "/usr/local/include/eigen3", "/opt/homebrew/include/eigen3")

_MISSING: Final = (
    "Pinocchio in C++ is left out: it needs the packages pin and casadi, Eigen's headers, and g++ or clang++"
)


def program(name: str) -> tuple[Path | None, str]:
    """Return a program, `CALLS` or `GENERATE`, built if it is not there, or None and why there is none."""
    found, command = _command(name)
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


def _command(name: str) -> tuple[Path, list[str] | None]:
    """Return where a program is kept and the command that compiles it, None where something lacks."""
    packages = Path(sysconfig.get_path("purelib"))
    prefix, casadi = packages / "cmeel.prefix", packages / "casadi"
    compiler = shutil.which(os.environ.get("CXX", "")) or shutil.which("g++") or shutil.which("clang++")
    own = casadi / "include" / "eigen3"
    eigen = next((folder for folder in (*EIGEN, str(own)) if Path(folder).is_dir()), None)
    config = prefix / "include" / "pinocchio" / "config.hpp"
    source, flags = Path(__file__).with_name(f"{name}.cpp"), (*OPTIMIZED[name], *FLAGS)
    text = source.read_bytes() + " ".join(flags).encode() + str(prefix).encode()
    if config.is_file():
        text += config.read_bytes()
    found = kept_folder() / f"pinocchio_{name}_{hashlib.sha256(text).hexdigest()[:12]}"
    if compiler is None or eigen is None or not config.is_file():
        return found, None
    paths = ["-I", str(prefix / "include"), "-I", eigen, "-L", str(prefix / "lib")]
    boost = sorted((prefix / "lib").glob("libboost_serialization.so*"))
    libraries = [str(boost[0])] if boost else ["-lboost_serialization"]
    if name == GENERATE:
        theirs = sorted(casadi.glob("libcasadi.so*"))
        if not theirs:
            return found, None
        paths += ["-I", str(casadi / "include")]
        libraries += [str(theirs[0]), f"-Wl,-rpath,{casadi}"]
    return found, [compiler, *flags, *paths, str(source), *libraries, f"-Wl,-rpath,{prefix / 'lib'}"]
