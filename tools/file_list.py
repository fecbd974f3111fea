"""List all files of the package by folder, each with the first line of its docstring: a page of the site.

    python tools/file_list.py

prints that page as Markdown.
"""

from __future__ import annotations

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "holdfast"
HEAD = """# All files

Made from the first line of every docstring. [Architecture](/architecture.md) says how the folders stand on each other.
"""


def page() -> str:
    """Return the list as Markdown, a section for each folder."""
    parts = [HEAD]
    for folder in sorted({path.parent for path in PACKAGE.rglob("*.py")}):
        name = folder.relative_to(PACKAGE.parent).as_posix()
        parts.append(f"## `{name}/`\n\n{first_line(folder / '__init__.py')}\n")
        files = sorted(path for path in folder.glob("*.py") if path.name != "__init__.py")
        parts.append("".join(f"- `{path.name}`: {first_line(path)}\n" for path in files))
    return "\n".join(parts)


def first_line(path: Path) -> str:
    """Return the first line of a module's docstring, with code as Markdown writes it."""
    said = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    if not said:
        raise ValueError(f"{path}: has no docstring; begin it with one line that says what is in the file")
    return said.splitlines()[0].replace("``", "`")


if __name__ == "__main__":
    print(page(), end="")
