"""Numbers with a name in holdfast: list them by package, and check that each has a reason and one home.

    python tools/constants.py list [PACKAGE]      # every constant with its module, value and reason
    python tools/constants.py check               # prints what is wrong, ends with 1 if there is anything

A constant is a module's name in capitals whose value is worked out from numbers alone. One that derives from another
has no choice of its own and does not count towards the ceiling of its package.
"""

from __future__ import annotations

import argparse
import ast
import re
import sys
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "holdfast"
NAME = re.compile(r"_?[A-Z][A-Z0-9_]*")
PARTS = (ast.Constant, ast.BinOp, ast.UnaryOp, ast.operator, ast.unaryop, ast.Name, ast.Attribute, ast.Call, ast.Load)

FUNCTIONS = ("arccos", "cos", "deg2rad", "finfo", "log", "radians", "sin", "sqrt", "tan")
CALLS = {"float", *(f"{library}.{name}" for library in ("np", "math") for name in FUNCTIONS)}

# The most constants of a package; one that is not listed may have MOST of them
CEILINGS = {
    "applications/placement": 63,
    "base": 32,
    "contacts": 91,
    "drawing": 86,
    "elastic": 96,
    "engines/compliant": 82,
    "engines/limit": 51,
    "geometry": 62,
    "settling": 44,
}
MOST = 25

# Different things of one package that happen to have the same name and number
UNLIKE = {("engines/compliant", "FARTHEST"), ("scene/formats/simulators", "FREE")}


@dataclass(frozen=True)
class Constant:
    """One constant: the ``package`` and ``module`` that it is in, its ``value`` as written, and the comment on it."""

    package: str
    module: str
    name: str
    value: str
    reason: str
    derived: bool


def constants_of(module: str, source: str) -> Iterator[Constant]:
    """The constants of a module, whose name is its path below the package holdfast."""
    lines = source.splitlines()
    for statement in ast.parse(source).body:
        if not isinstance(statement, ast.Assign | ast.AnnAssign) or statement.value is None:
            continue
        target = statement.targets[0] if isinstance(statement, ast.Assign) else statement.target
        names, values = [target], [statement.value]
        if isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple):
            names, values = target.elts, statement.value.elts
        for name, value in zip(names, values, strict=True):
            if isinstance(name, ast.Name) and NAME.fullmatch(name.id) and numeric(value):
                package = module.rpartition("/")[0] or "front"
                used = {node.id for node in ast.walk(value) if isinstance(node, ast.Name)}
                derived = any(NAME.fullmatch(other) for other in used)
                yield Constant(package, module, name.id, ast.unparse(value), reason(lines, statement), derived)


def numeric(value: ast.expr) -> bool:
    """Whether an expression is worked out from numbers alone."""
    nodes = list(ast.walk(value))
    numbers = [node.value for node in nodes if isinstance(node, ast.Constant)]
    called = {ast.unparse(node.func) for node in nodes if isinstance(node, ast.Call)}
    return (
        all(isinstance(node, PARTS) for node in nodes)
        and bool(numbers)
        and all(isinstance(number, int | float) and not isinstance(number, bool) for number in numbers)
        and called <= CALLS
    )


def reason(lines: list[str], statement: ast.stmt) -> str:
    """The comment beside a statement, or right above it."""
    last = statement.end_lineno or statement.lineno
    _, mark, beside = lines[last - 1][statement.end_col_offset or 0 :].partition("#")
    if mark:
        return beside.strip()
    above: list[str] = []
    number = statement.lineno - 2
    while number >= 0 and lines[number].startswith("#"):
        above.insert(0, lines[number].lstrip("# ").strip())
        number -= 1
    return " ".join(above)


def constants() -> list[Constant]:
    """All constants of holdfast."""
    paths = sorted(SOURCE.rglob("*.py"))
    modules = [(path.relative_to(SOURCE).as_posix(), path.read_text(encoding="utf-8")) for path in paths]
    return [found for module, source in modules for found in constants_of(module, source)]


def faults(found: list[Constant]) -> list[str]:
    """What is wrong: constants without a reason, with two homes in one package, or too many in a package."""
    wrong = [f"{c.module}: {c.name} has no comment that says why it is {c.value}" for c in found if not c.reason]
    homes: defaultdict[tuple[str, str, str], list[str]] = defaultdict(list)
    for c in found:
        homes[c.package, c.name, c.value].append(c.module)
    wrong += [
        f"{package}: {name} = {value} is in {' and '.join(modules)}: give it one home"
        for (package, name, value), modules in homes.items()
        if len(modules) > 1 and (package, name) not in UNLIKE
    ]
    for package, count in counts(found).items():
        ceiling = CEILINGS.get(package, MOST)
        if count > ceiling:
            wrong.append(f"{package}: {count} constants, more than {ceiling}: derive, merge or remove some")
    return wrong


def counts(found: list[Constant]) -> Counter[str]:
    """Number of constants of each package that do not derive from others, nor from the enumerations of MuJoCo."""
    return Counter(c.package for c in found if not c.derived and not re.match("mj[A-Z]", c.reason))


def main() -> int:
    """Run one command."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["list", "check"])
    parser.add_argument("package", nargs="?", help="list this package alone, such as engines/limit")
    chosen = parser.parse_args()
    found = constants()
    if chosen.what == "check":
        wrong = faults(found)
        print("\n".join(wrong) or f"{len(found)} constants, each with a reason and one home")
        return bool(wrong)
    for c in found:
        if chosen.package in (None, c.package):
            print(f"{c.module}: {c.name} = {c.value}  # {c.reason}")
    for package, count in counts(found).most_common():
        if chosen.package in (None, package):
            print(f"{count:5} {package}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
