"""The list of public names with a line for each, and a page for each: signature, docstring, parameters, an example.

Lines and texts are those of the docstrings, units and meanings those of ``tools/vocabulary.csv``. An example is a
snippet of a page of docs/ that uses the name, with the statements before it that it needs.
"""

from __future__ import annotations

import ast
import builtins
import enum
import functools
import inspect
import re
import textwrap
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import vocabulary

import holdfast as hf

DOCS = Path(__file__).parents[1]
MODULES = (hf, hf.sets, hf.answers, hf.errors, hf.readers, hf.plugins)
SHELVES = ("howto", "from", "explanation", "reference", "")  # folders of pages with snippets, the first preferred
GROUP = re.compile(r"```\{names\} *(?P<module>[\w.]+)\n(?P<names>.*?)```", re.DOTALL)
BLOCK = re.compile(r"```(?P<kind>[\w{}-]*)\n(?P<code>.*?)```", re.DOTALL)
VALUES = {  # what has no docstring of its own
    "holdfast.plugins.Accuracy": "How accurate an answer must be: `EXACT`, or less where that saves time.",
    "holdfast.plugins.EXACT": "The accuracy of all questions that ask for none: as exact as the engine can.",
}
SEEN = 5  # the most pages that a page of a name leads to
MEMBERS = "   :members:\n   :inherited-members: tuple, Exception, BaseException, StrEnum, str, Mapping\n"
MEMBERS += "   :exclude-members: checked_after_load\n"
TABLE = ".. list-table::\n   :header-rows: 1\n\n   * - parameter\n     - unit\n     - meaning"


class Snippet(NamedTuple):
    """A block of Python of a page: the page, the block's number there, its text, its statements, what it names."""

    page: str  # as the site calls it: howto/pack
    number: int
    code: str
    body: tuple[ast.stmt, ...]
    used: frozenset[str]  # public names, "holdfast.Scene"
    read: frozenset[str]  # names of attributes that it reads


class Example(NamedTuple):
    """What a page shows of a name: the page, its heading, and the code, which runs by itself."""

    page: str
    heading: str
    code: str


@functools.cache
def public_names() -> dict[str, Any]:
    """All public names with their values, such as ``holdfast.sets.Uncertain``."""
    return {f"{module.__name__}.{name}": getattr(module, name) for module in MODULES for name in module.__all__}


def line_of(name: str) -> str:
    """Return what a name is, in one line of Markdown: the first of its docstring."""
    said = VALUES.get(name) or (inspect.getdoc(public_names()[name]) or "").splitlines()[0]
    return re.sub(r"``(.*?)``", r"`\1`", said).replace("|", "\\|")


def grouped(page: str) -> list[tuple[str, ...]]:
    """Return the names of each group of a page of names; all of a module where the page gives none."""
    groups = []
    for group in GROUP.finditer(page):
        everything = [name for name in public_names() if name.rpartition(".")[0] == group["module"]]
        groups.append(tuple(f"{group['module']}.{name}" for name in group["names"].split()) or tuple(everything))
    return groups


def with_lines(page: str) -> str:
    """Return a page of names with a line for each name of its groups, which leads to the page of the name."""
    groups = grouped(page)
    entries = "".join(f"/files/api/{name}\n" for group in groups for name in group)
    tables = iter(groups)
    page = GROUP.sub(lambda _: _table(next(tables)), page)
    return f"{page}\n```{{toctree}}\n:hidden:\n\n{entries}```\n"


def _table(names: Iterable[str]) -> str:
    rows = [f"| [`{name.rpartition('.')[2]}`](/files/api/{name}.rst) | {line_of(name)} |" for name in names]
    return "\n".join(["", "| name | what it is |", "|---|---|", *rows])


def page_of(name: str) -> str:
    """Return the page of a public name, as reStructuredText."""
    value, short = public_names()[name], name.rpartition(".")[2]
    parts = [VALUES[name].replace("`", "``")] if name in VALUES else []
    rows = list(_parameters(value))
    parts += [".. rubric:: Parameters", "\n".join([TABLE, *rows])] if rows else []
    example = None if ">>>" in (inspect.getdoc(value) or "") else examples().get(name)
    if example is not None:
        said = f"From :doc:`{example.heading} </{example.page}>`:"
        parts += [".. rubric:: Example", said, ".. code-block:: python\n\n" + textwrap.indent(example.code, "   ")]
    seen = [f":doc:`{title} </{page}>`" for page, title in mentions(name) if example is None or page != example.page]
    parts += [f"See also: {', '.join(seen[:SEEN])}."] if seen else []
    content = textwrap.indent("\n\n".join(parts), "   ")
    return f"{short}\n{'=' * len(short)}\n\n.. {_directive(name, value)}\n\n{content}\n"


def _directive(name: str, value: object) -> str:
    if inspect.isclass(value):
        more = {"show-inheritance": issubclass(value, BaseException), "undoc-members": issubclass(value, enum.Enum)}
        return f"autoclass:: {name}\n{MEMBERS}" + "".join(f"   :{option}:\n" for option, on in more.items() if on)
    return f"autofunction:: {name}" if inspect.isfunction(value) else f"autodata:: {name}\n   :no-value:"


def _parameters(value: Any) -> Iterator[str]:  # noqa: ANN401 - any public value
    """Give the rows of the table of parameters, of calls that the table of words knows."""
    known = vocabulary.words()
    if value in (call for _, call in vocabulary.calls()):
        for each in vocabulary.parameters(value):
            if each.name in known:
                word = known[each.name]
                cells = (f"``{each.name}``", word.unit, word.meaning.replace("`", "``"))
                yield "\n".join(f"   {'  ' if k else '* '}- {cell}".rstrip() for k, cell in enumerate(cells))


@functools.cache
def pages() -> dict[str, str]:
    """The texts of all pages with snippets by name, such as howto/pack, those of preferred folders first."""
    paths = [path for shelf in SHELVES for path in sorted((DOCS / shelf).glob("*.md"))]
    return {path.relative_to(DOCS).with_suffix("").as_posix(): path.read_text(encoding="utf-8") for path in paths}


def heading(page: str) -> str:
    """The title of a page, as plain text."""
    return pages()[page].partition("# ")[2].partition("\n")[0].replace("`", "")


def mentions(name: str) -> Iterator[tuple[str, str]]:
    """Give the pages, with their titles, that name a public name in code."""
    said = re.compile(rf"`[^`]*\b{re.escape(name.replace('holdfast.', 'hf.', 1))}\b|`{name.rpartition('.')[2]}[`(]")
    yield from (
        (page, heading(page)) for page, text in pages().items() if page != "reference/api" and said.search(text)
    )


@functools.cache
def snippets() -> tuple[Snippet, ...]:
    """All blocks of Python of the pages, those of preferred pages first."""
    return tuple(
        _snippet(page, number, code)
        for page, text in pages().items()
        for number, code in enumerate(code for kind, code in BLOCK.findall(text) if kind == "python")
    )


def _snippet(page: str, number: int, code: str) -> Snippet:
    body, used = tuple(ast.parse(code).body), set[str]()
    for node in ast.walk(ast.Module([*body], [])):
        if isinstance(node, ast.Attribute):
            used.add(re.sub(r"^hf\b", "holdfast", ast.unparse(node)))
        elif isinstance(node, ast.ImportFrom):
            used |= {f"{node.module}.{alias.name}" for alias in node.names}
    read = {node.attr for node in ast.walk(ast.Module([*body], [])) if isinstance(node, ast.Attribute)}
    return Snippet(page, number, code, body, frozenset(used & public_names().keys()), frozenset(read))


@functools.cache
def examples() -> dict[str, Example]:
    """The example of each public name that the pages use, or whose values they read from an answer."""
    found: dict[str, Snippet] = {}
    for name in public_names():
        using = [each for each in snippets() if name in each.used] or list(_showing(name))
        if using:
            pages = [each.page for each in using]
            found[name] = min(using, key=lambda each: _rank(each, pages.count(each.page)))
    return {name: _example(snippet) for name, snippet in found.items()}


def _rank(snippet: Snippet, uses: int) -> tuple[bool, bool, bool, int, int, int]:
    """Order snippets: first those that print, need no other package and no file; then by page; the shortest first."""
    code = _example(snippet).code
    shelf = SHELVES.index(snippet.page.rpartition("/")[0])
    foreign = {*re.findall(r"^(?:import|from) (\w+)", code, re.MULTILINE)} - {"holdfast", "math", "numpy"}
    return "print(" not in code, bool(foreign), "load_scene(" in code, shelf, -uses, len(code)


def _showing(name: str) -> Iterator[Snippet]:
    """Give the snippets that ask for a value of this type or, if none does, that read one from another value."""
    asking = [each for each in snippets() if each.used & _giving(name)]
    if asking:
        yield from asking
        return
    for owner, value in public_names().items():
        read = {attribute for attribute, kind in _attributes(value) if _names(kind, name)}
        known = {owner} | _giving(owner)
        for page in {each.page for each in snippets() if each.used & known} if read else ():
            yield from (each for each in snippets() if each.page == page and each.read & read)


def _giving(name: str) -> set[str]:
    """The public functions that return a value of this type."""
    functions = ((other, value) for other, value in public_names().items() if inspect.isfunction(value))
    return {other for other, value in functions if _names(value.__annotations__.get("return", ""), name)}


def _attributes(value: object) -> Iterator[tuple[str, object]]:
    """Give the attributes of a public class, each with the type that it has or, of a method, returns."""
    for base in value.__mro__ if inspect.isclass(value) else ():
        yield from inspect.get_annotations(base).items()
        for attribute, member in vars(base).items():
            function = member.fget if isinstance(member, property) else member
            if inspect.isfunction(function):
                yield attribute, function.__annotations__.get("return", "")


def _names(kind: object, name: str) -> bool:
    """Whether an annotation, as text, names a type."""
    return name.rpartition(".")[2] in re.findall(r"\w+", str(kind))


@functools.cache
def _example(snippet: Snippet) -> Example:
    """Return a snippet with the statements of earlier ones of its page that it needs, imports first."""
    earlier = [each for each in snippets() if each.page == snippet.page and each.number < snippet.number]
    before = [(each, statement) for each in earlier for statement in each.body]
    wanted, kept = _missing(snippet.body), list[int]()
    for k in range(len(before) - 1, -1, -1):
        made = _made(before[k][1])
        if made & wanted:
            kept.append(k)
            wanted = (wanted - made) | _missing([before[k][1]])
    texts = [_text(*before[k]) for k in reversed(kept)]
    imports = [text for text in texts if re.match(r"import |from ", text)]
    others = [text for text in texts if text not in imports]
    begun = "".join(f"{text}\n" for text in sorted(imports, key=lambda text: "holdfast" in text))
    parts = [begun, "\n".join(others), snippet.code.strip()]
    return Example(snippet.page, heading(snippet.page), "\n".join(part for part in parts if part))


def _text(snippet: Snippet, statement: ast.stmt) -> str:
    """Return the lines of a statement, with the comment behind it."""
    return "\n".join(snippet.code.splitlines()[statement.lineno - 1 : statement.end_lineno])


def _made(statement: ast.AST) -> set[str]:
    """The names that a statement, or the target of a loop, gives a value."""
    made = set[str]()
    for node in ast.walk(statement):
        if isinstance(node, ast.Import | ast.ImportFrom):
            made |= {(alias.asname or alias.name).partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ClassDef):
            made.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            made.add(node.id)
    return made


def _missing(body: Iterable[ast.stmt]) -> set[str]:
    """The names that statements read before they are made."""
    known, missing = {*dir(builtins)}, set[str]()
    for statement in body:
        nodes = list(ast.walk(statement))
        inner = {node.arg for node in nodes if isinstance(node, ast.arg)}
        whole = isinstance(statement, ast.FunctionDef | ast.ClassDef | ast.For | ast.While | ast.With)
        targets = [statement] if whole else [node.target for node in nodes if isinstance(node, ast.comprehension)]
        inner |= {name for target in targets for name in _made(target)}
        missing |= {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Load)} - known - inner
        known |= _made(statement)
    return missing
