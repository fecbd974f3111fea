"""What pip calls to build holdfast: scikit-build-core, with a compiler from the package index where there is none.

pyproject.toml names it. Where neither CXX nor a ``c++`` is at hand, on Linux and macOS, ziglang is asked for beside
CMake and Ninja, and its binary compiles. An editable install builds into build/ and puts the core beside its sources,
so that whatever reads this checkout finds it; and it is no more than a path: scikit-build-core's own would lead Python
there even where PYTHONPATH names another checkout.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from scikit_build_core import build as core

ROOT = Path(__file__).parents[1]
SOURCES = ROOT / "src" / "holdfast" / "native"
COMPILER = "ziglang>=0.13"
BUILT_HERE = {
    "wheel.cmake": "false",
    "wheel.py-api": "py3",
}  # of an editable install, whose core is in its place already

Settings = dict[str, Any] | None


def lacks_compiler() -> bool:
    """Whether nothing on this machine says how to compile C++; CMake finds those of Windows by itself."""
    known = ("c++", "g++", "clang++")
    return os.name != "nt" and "CXX" not in os.environ and not any(map(shutil.which, known))


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """What a wheel needs before it is built."""
    return [*core.get_requires_for_build_wheel(config_settings), *([COMPILER] if lacks_compiler() else [])]


def get_requires_for_build_editable(config_settings: Settings = None) -> list[str]:
    """What an editable install needs before it is built."""
    return get_requires_for_build_wheel(config_settings)


def build_wheel(folder: str, config_settings: Settings = None, metadata_directory: str | None = None) -> str:
    """Build a wheel into ``folder``, and return its name."""
    with compiler():
        return str(core.build_wheel(folder, config_settings, metadata_directory))


def build_editable(folder: str, config_settings: Settings = None, metadata_directory: str | None = None) -> str:
    """Build the core into its place in the checkout, and a wheel into ``folder`` that leads there; return its name."""
    tag = f"{sys.implementation.cache_tag}-{sysconfig.get_platform()}"
    made = ROOT / "build" / f"native-{tag}"
    shutil.rmtree(made, ignore_errors=True)  # it names the environment of the build before, which is gone
    configured = ["cmake", "-S", str(SOURCES), "-B", str(made), f"-DPython_EXECUTABLE={sys.executable}"]
    with compiler():
        more = [*shlex.split(os.environ.get("CMAKE_ARGS", "")), *(["-GNinja"] if shutil.which("ninja") else [])]
        subprocess.run([*configured, *more], check=True)
        subprocess.run(["cmake", "--build", str(made), "--config", "Release", "--parallel"], check=True)
    with tempfile.TemporaryDirectory() as content:
        known = prepare_metadata_for_build_editable(content, config_settings)
        Path(content, "holdfast.pth").write_text(f"{ROOT / 'src'}\n")
        files = sorted(path.relative_to(content).as_posix() for path in Path(content).rglob("*") if path.is_file())
        record = f"{known}/RECORD"
        Path(content, record).write_text("".join(f"{name},,\n" for name in [*files, record]))
        wheel = f"{known.removesuffix('.dist-info')}-py3-none-any.whl"
        with zipfile.ZipFile(Path(folder, wheel), "w") as into:
            for name in [*files, record]:
                into.write(Path(content, name), name)
    return wheel


def prepare_metadata_for_build_editable(folder: str, config_settings: Settings = None) -> str:
    """Write the metadata of an editable install into ``folder``, and return their name."""
    return str(core.prepare_metadata_for_build_editable(folder, {**(config_settings or {}), **BUILT_HERE}))


build_sdist = core.build_sdist
get_requires_for_build_sdist = core.get_requires_for_build_sdist
prepare_metadata_for_build_wheel = core.prepare_metadata_for_build_wheel


@contextmanager
def compiler() -> Iterator[None]:
    """Let CMake use the binary of ziglang, by small scripts that go again, where there is no other compiler."""
    if not lacks_compiler():
        yield
        return
    spec = find_spec("ziglang")
    if spec is None or spec.origin is None:
        raise SystemExit(f"no C++ compiler: neither CXX nor c++, and no {COMPILER} in the environment that builds")
    binary = Path(spec.origin).parent / "zig"
    with tempfile.TemporaryDirectory() as folder:
        for variable, command in (("CXX", "c++"), ("CC", "cc"), ("CMAKE_AR", "ar"), ("CMAKE_RANLIB", "ranlib")):
            script = Path(folder) / command
            script.write_text(f'#!/bin/sh\nexec "{binary}" {command} "$@"\n')
            script.chmod(0o755)
            if variable.startswith("CMAKE"):
                os.environ["CMAKE_ARGS"] = f"{os.environ.get('CMAKE_ARGS', '')} -D{variable}={shlex.quote(str(script))}"
            else:
                os.environ[variable] = str(script)
        yield
