"""Deliberate breaks: apply each of them in a copy of this checkout, and see which tests notice.

    python tools/mutants.py list [--rooms ROOM ...]
    python tools/mutants.py run [NAME ...] [--rooms ROOM ...] [--sample N [--seed S]] [--jobs J] [--trust] [--limit S]

The breaks are in tools/mutants/ROOM.toml. ``tests`` at the top are run for every break of the file that names none::

    tests = ["tests/contacts"]
    [[break]]
    name = "gap-sign"                        # unique over all files
    file = "src/holdfast/contacts/gaps.py"
    old = "words that occur once in the file"
    new = "what is there instead"
    stands_for = "Which mistake of a programmer, or of a convention, this is."
    tests = ["tests/closed_form"]            # optional

``run`` first sees all tests pass in the unbroken copy (``--trust`` leaves this out). It prints a line for each break:
``caught NAME by K tests: ...``, where parameters of one test count once, or ``survived NAME``. A run that takes longer
than its limit, or whose process dies, is caught, too: nobody overlooks that. The status is 0 if all are caught, 1 if
some survive, and 2 if the list does not fit the sources: before anything is run, but for a broken core that does not
compile. The first break of the core compiles all of it, and later ones what depends on their files.
"""

from __future__ import annotations

import argparse
import ast
import importlib.util
import os
import random
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import tomllib
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

ROOT = Path(__file__).parents[1]
QUICK = "not slow and not referee"  # the tests of `make test`
LIMIT = 900.0  # seconds for the tests of one break, on a machine that does other things too
SHOWN = 12  # tests named for each break
NOTICED = "MUTANTS_NOTICED"  # environment variable with the file in which a run of pytest lists the tests that failed
TEXTS = ("name", "file", "old", "new", "stands_for")  # what each break says
NATIVE = "src/holdfast/native"  # what is broken there is compiled anew


class ListError(Exception):
    """Says what is wrong with the list of breaks, or with the checkout that they are tried in."""


@dataclass(frozen=True)
class Break:
    """One deliberate mistake: ``old`` replaced by ``new`` in ``file``, which ``tests`` are to notice."""

    room: str
    name: str
    file: str
    old: str
    new: str
    stands_for: str
    tests: tuple[str, ...]

    def broken(self, text: str) -> str:
        """Return the contents of the file with the break in it."""
        return text.replace(self.old, self.new)

    def faults(self, root: Path) -> list[str]:
        """Return what does not fit the sources, in words."""
        path = root / self.file
        if not path.is_file():
            return [f"{self.name}: there is no {self.file}"]
        found = [f"{self.name}: there is no {t}" for t in self.tests if not (root / t.partition("::")[0]).exists()]
        if not self.tests:
            found.append(f"{self.name}: names no tests")
        text = path.read_text(encoding="utf-8")
        if text.count(self.old) != 1:
            found.append(f"{self.name}: its words are {text.count(self.old)} times in {self.file}: {self.old!r}")
        elif path.suffix != ".py":
            found += [f"{self.name}: changes nothing"] if self.old == self.new else []
        else:
            try:
                if ast.dump(ast.parse(text)) == ast.dump(ast.parse(self.broken(text))):
                    found.append(f"{self.name}: changes nothing but how {self.file} looks")
            except SyntaxError as error:
                found.append(f"{self.name}: leaves {self.file} with a syntax error: {error}")
        return found


@dataclass(frozen=True)
class Run:
    """How a run of tests ended: the tests that failed, without parameters, and how many of each; words for its end."""

    failed: Counter[str]
    end: str

    @property
    def noticed(self) -> bool:
        """Whether anything went wrong."""
        return bool(self.failed or self.end)

    def __str__(self) -> str:
        names = [f"{name} ({count})" if count > 1 else name for name, count in self.failed.items()]
        more = [f"and {len(names) - SHOWN} more"] if len(names) > SHOWN else []
        return ", ".join([*([self.end] if self.end else []), *names[:SHOWN], *more])


def breaks(root: Path) -> list[Break]:
    """Return the list; raise ListError if it does not fit the sources."""
    found, faults = list[Break](), list[str]()
    for path in sorted((root / "tools" / "mutants").glob("*.toml")):
        table = tomllib.loads(path.read_text(encoding="utf-8"))
        faults += [f"{path.name}: unknown: {key}" for key in table.keys() - {"tests", "break"}]
        for entry in table.get("break", []):
            wrong = [key for key in TEXTS if not (isinstance(entry.get(key), str) and entry[key])]
            wrong = [key for key in wrong if not (key == "new" and entry.get("new") == "")]
            wrong += sorted(entry.keys() - {*TEXTS, "tests"})
            if wrong:
                faults.append(f"{path.name}: {entry.get('name', '?')}: missing or unknown: {', '.join(wrong)}")
            else:
                tests = tuple(entry.get("tests", table.get("tests", ())))
                found.append(Break(path.stem, **{key: entry[key] for key in TEXTS}, tests=tests))
    twice = [name for name, count in Counter(one.name for one in found).items() if count > 1]
    faults += [f"{name}: is there twice" for name in twice]
    faults += [fault for one in found for fault in one.faults(root)]
    if faults:
        raise ListError("\n".join(faults))
    return found


class Copy:
    """A copy of a checkout, with its compiled core, in which one break at a time is tried."""

    def __init__(self, root: Path, folder: Path) -> None:
        self.root, self._built, self._noticed = folder / "checkout", folder / "built", folder / "noticed"
        self._source = root
        self._child: subprocess.Popen[bytes] | None = None
        listing = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
        listed = subprocess.run(listing, cwd=root, capture_output=True, text=True, check=True)
        for name in filter(None, listed.stdout.split("\0")):
            if (root / name).is_file():  # not one that was removed and is still in the index
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, self.root / name, follow_symlinks=False)
        for command in (["init", "-q"], ["add", "-A"]):  # some tests ask git for the files
            subprocess.run(["git", *command], cwd=self.root, check=True, capture_output=True)
        beside = next((p / "shared" for p in root.parents if (p / "shared" / "cases").is_dir()), None)
        if beside is not None:  # the cases that tests look for beside the checkout
            (folder / "shared").symlink_to(beside)
        self._cores = [p.relative_to(root) for p in (root / NATIVE).glob("core.*") if p.suffix in {".so", ".pyd"}]
        self._take_cores(root)

    def _take_cores(self, root: Path) -> None:
        for core in self._cores:
            (self.root / core).unlink(missing_ok=True)  # a process may still run it: never written over
            shutil.copy2(root / core, self.root / core)

    def _compile(self) -> str:
        """Compile the core of this copy into its place; return what the compiler said if that failed."""
        for core in self._cores:
            (self.root / core).unlink(missing_ok=True)
        ninja = ["-G", "Ninja"] if shutil.which("ninja") else []
        sought = f"-DPython_EXECUTABLE={sys.executable}"
        for command in (
            ["cmake", "-S", str(self.root / NATIVE), "-B", str(self._built), sought, *ninja],
            ["cmake", "--build", str(self._built), "--target", "core"],
        ):
            self._child = child = subprocess.Popen(
                command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True
            )
            said = [line for line in child.communicate()[0].decode(errors="replace").splitlines() if "error" in line]
            if child.returncode != 0:
                return "\n".join(said[:SHOWN]) or f"{' '.join(command)} ended with {child.returncode}"
        return ""

    def environment(self) -> dict[str, str]:
        """Return that of a run: modules from the copy alone, and this file as a plugin of pytest."""
        paths = [self.root / "src", self.root / "tools", Path(__file__).parent]
        found = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths)), NOTICED: str(self._noticed)}
        return {**found, "OPENBLAS_NUM_THREADS": "1"}

    def check_core(self, files: Iterable[str]) -> None:
        """Raise ListError if one of ``files`` is part of the core, and this copy has no core that could be broken."""
        if not any(file.startswith(NATIVE) for file in files):
            return
        if not self._cores:
            raise ListError(f"there is no compiled core in {NATIVE}: compile it first, as CMakeLists.txt there says")
        if shutil.which("cmake") is None:
            raise ListError("breaks of the core need cmake and a compiler: there is no cmake")

    def check_imports(self, files: Iterable[str]) -> None:
        """Raise ListError if Python would take a package of ``files`` from anywhere but this copy."""
        for package in {Path(file).parts[1] for file in files if file.startswith("src/")}:
            ask = f"import importlib.util; print(importlib.util.find_spec({package!r}).origin)"
            environment = self.environment()
            asked = subprocess.run([sys.executable, "-c", ask], env=environment, capture_output=True, text=True)
            if not Path(asked.stdout.strip()).is_relative_to(self.root):
                raise ListError(f"{package} is imported from {asked.stdout.strip()}, not from the copy")

    def run(self, tests: Iterable[str], limit: float) -> Run:
        """Run tests as they are in `make test`."""
        self._noticed.write_text("")
        options = ["-p", "no:cacheprovider", "-p", Path(__file__).stem, "-q", "--tb=no", "-m", QUICK]
        self._child = child = subprocess.Popen(
            [sys.executable, "-m", "pytest", *options, *tests],
            cwd=self.root, env=self.environment(),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True,
        )  # fmt: skip
        try:
            status = child.wait(limit)
            end = "" if status in (0, 1) else f"pytest ended with {status}"
        except subprocess.TimeoutExpired:
            end = "out of time"
        finally:
            self.stop()
        failed = Counter(line.partition("[")[0] for line in self._noticed.read_text().splitlines())
        return Run(failed, end)

    def stop(self) -> None:
        """End a run of tests or of the compiler, with what it started."""
        if self._child is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._child.pid, signal.SIGKILL)
            self._child.wait()

    def try_out(self, one: Break, limit: float) -> Run:
        """Run the tests of a break with the break in place, and repair the copy."""
        path, native = self.root / one.file, one.file.startswith(NATIVE)
        text = path.read_bytes()
        try:
            self._write(path, one.broken(text.decode()).encode())
            if native and (said := self._compile()):
                raise ListError(f"{one.name}: the broken core does not compile: {said}")
            return self.run(one.tests, limit)
        finally:
            self._write(path, text)
            if native:
                self._take_cores(self._source)

    @staticmethod
    def _write(path: Path, text: bytes) -> None:
        path.write_bytes(text)
        if path.suffix == ".py":  # bytecode is known by second and size alone, and both may be those of another text
            Path(importlib.util.cache_from_source(str(path))).unlink(missing_ok=True)


def pytest_runtest_logreport(report: Any) -> None:  # noqa: ANN401 - types of pytest, which the tool itself does not need
    """As a plugin of pytest: write down each test that fails."""
    if report.failed:
        with Path(os.environ[NOTICED]).open("a") as file:
            file.write(f"{report.nodeid}\n")


pytest_collectreport = pytest_runtest_logreport  # a module that cannot be imported


def run(chosen: Sequence[Break], root: Path, *, jobs: int, trust: bool, limit: float) -> int:
    """Try breaks out, ``jobs`` at a time; return the status of the command."""
    survived, counts, copies = list[str](), list[int](), SimpleQueue[Copy]()
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        made = [Copy(root, Path(folder) / str(k)) for k in range(min(jobs, len(chosen)))]
        made[0].check_imports(one.file for one in chosen)
        made[0].check_core(one.file for one in chosen)
        if not trust:
            tests = list(dict.fromkeys(test for one in chosen for test in one.tests))
            unbroken = made[0].run(tests, limit * len({one.tests for one in chosen}))
            if unbroken.noticed:
                raise ListError(f"the unbroken copy does not pass its tests: {unbroken}")
        for copy in made:
            copies.put(copy)

        def tried(one: Break) -> Run:
            copy = copies.get()
            try:
                return copy.try_out(one, limit)
            finally:
                copies.put(copy)

        with ThreadPoolExecutor(len(made)) as pool:
            try:
                for one, found in zip(chosen, pool.map(tried, chosen), strict=True):
                    survived += [] if found.noticed else [one.name]
                    counts += [len(found.failed)] if found.noticed else []
                    told = f"caught {one.name} by {len(found.failed)} tests: {found}"
                    print(told if found.noticed else f"survived {one.name}", flush=True)
            except BaseException:  # Ctrl-C: runs are in sessions of their own, and the pool waits for them
                pool.shutdown(wait=False, cancel_futures=True)
                for copy in made:
                    copy.stop()
                raise
    if counts:
        print(f"noticed by a median of {statistics.median(counts):g} tests, and by {min(counts)} at least")
    print(f"caught {len(counts)}, survived: {len(survived)}")
    return 1 if survived else 0


def main(arguments: Sequence[str] | None = None, root: Path = ROOT) -> int:
    """Run one command on a checkout."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["list", "run"])
    parser.add_argument("names", nargs="*", metavar="NAME", help="only these")
    parser.add_argument("--rooms", nargs="+", default=[], help="only the breaks of these files")
    parser.add_argument("--sample", type=int, help="only so many, drawn by lot")
    parser.add_argument("--seed", type=int, default=0, help="of the lot")
    parser.add_argument("--jobs", type=int, default=1, help="breaks tried at a time")
    parser.add_argument("--trust", action="store_true", help="do not run the tests without a break first")
    parser.add_argument("--limit", type=float, default=LIMIT, help="seconds for the tests of one break")
    options = parser.parse_intermixed_args(arguments)  # options may stand before names, too
    try:
        chosen = breaks(root)
        for wanted, known in ((options.rooms, {b.room for b in chosen}), (options.names, {b.name for b in chosen})):
            if unknown := sorted(set(wanted) - known):
                raise ListError(f"there is no {', '.join(unknown)}: known are {', '.join(sorted(known))}")
        chosen = [b for b in chosen if not options.rooms or b.room in options.rooms]
        chosen = [b for b in chosen if not options.names or b.name in options.names]
        if options.sample is not None:
            chosen = random.Random(options.seed).sample(chosen, min(options.sample, len(chosen)))
        if not chosen:
            raise ListError("no breaks: tools/mutants has none of these")
        if options.command == "run":
            return run(chosen, root, jobs=max(options.jobs, 1), trust=options.trust, limit=options.limit)
    except ListError as error:
        print(error, file=sys.stderr)
        return 2
    for room in dict.fromkeys(one.room for one in chosen):
        own = [one for one in chosen if one.room == room]
        print(f"{room} ({len(own)})")
        for one in own:
            print(f"  {one.name}  {one.file}\n    {one.stands_for}")
    return 0


if __name__ == "__main__":
    for number in (signal.SIGINT, signal.SIGTERM):  # the copies and what runs in them go, too
        signal.signal(number, signal.default_int_handler)
    sys.exit(main())
