"""Build wheel and sdist, and try each in a clean environment of every Python that this machine has.

    python tools/wheels.py [FOLDER]

Pythons are python3.11 to python3.14 on the PATH, and those that PYTHONS names, separated by colons. Tried is the core
without extras: a verdict, a push, and that a picture says which extra it needs. The wheel has to hold the committed
files of the package and its metadata, and nothing else.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
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
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "out/dist").resolve()
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    with tempfile.TemporaryDirectory() as clean:
        builder = environment(sys.executable, Path(clean))
        called(builder, "-m", "pip", "install", "--quiet", "build", "twine")
        called(builder, "-m", "build", "--outdir", str(folder), str(ROOT))
        called(builder, "-m", "twine", "check", "--strict", *map(str, folder.iterdir()))
    differing = different(next(folder.glob("*.whl")))
    failed = bool(differing)
    print("wheel: " + (", ".join(differing) or "holds the committed files of the package and nothing else"), flush=True)
    for version, python in pythons().items():
        for package in sorted(folder.iterdir()):
            with tempfile.TemporaryDirectory() as clean:
                try:
                    own = environment(python, Path(clean))
                    called(own, "-m", "pip", "install", "--quiet", "-c", str(ROOT / "constraints.txt"), str(package))
                    said = called(own, "-W", "error::DeprecationWarning:holdfast", "-c", TRIED, folder=Path(clean))
                except subprocess.CalledProcessError as error:
                    failed, said = True, f"FAILED: {error.stderr.strip()[-600:]}"
                print(f"Python {version}, {package.name}: {said}", flush=True)
    return int(failed)


def different(wheel: Path) -> list[str]:
    """Return the files that only the wheel or only the repository has; those of the wheel's metadata do not count."""
    listed = subprocess.run(["git", "ls-files", "src"], cwd=ROOT, capture_output=True, text=True, check=True)
    committed = {line.removeprefix("src/") for line in listed.stdout.splitlines()}
    name = "-".join(wheel.name.split("-")[:2])
    held = {each for each in zipfile.ZipFile(wheel).namelist() if not each.startswith(f"{name}.dist-info/")}
    return sorted(committed ^ held)


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
    subprocess.run([python, "-m", "venv", str(folder / "venv")], check=True)
    return str(folder / "venv" / "bin" / "python")


def called(python: str, *arguments: str, folder: Path | None = None) -> str:
    """Return what a call of Python printed; nothing of this environment leads it to other packages."""
    kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "PYTHONHOME")}
    done = subprocess.run([python, *arguments], cwd=folder, env=kept, capture_output=True, text=True, check=True)
    return done.stdout.strip()


if __name__ == "__main__":
    sys.exit(main())
