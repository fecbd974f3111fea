"""Safe reading of XML: no document types, so no entities or external references, and limits on size and depth."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from xml.parsers import expat

from holdfast.base.borders.foreign import ELEMENTS, foreign, spend
from holdfast.base.errors import HoldfastError, SceneError, message
from holdfast.base.text import quoted

MAX_BYTES = 20_000_000  # largest number of characters of a file
MAX_DEPTH = 100  # the deepest nesting that is accepted
MAX_ELEMENTS = 500_000  # largest number of elements of a file
LARGEST = 1e30  # largest number in an element, so that products do not overflow; ranges are checked later

_DECLARATION = re.compile(r"\s*<\?xml\b.*?\?>", re.DOTALL)
_BEFORE_ROOT = re.compile(r"\s+|<\?.*?\?>|<!--.*?-->", re.DOTALL)
_ROOT = re.compile(r"<(?:!DOCTYPE\s+)?([A-Za-z_][\w.:-]*)")
_COMMENT = re.compile(r"<!\[CDATA\[.*?\]\]>|<!--(.*?)-->", re.DOTALL)


@dataclass(eq=False)
class Element:
    """An element: its tag (with any prefix), attributes, text and children, and the file and line of its start."""

    tag: str
    attributes: dict[str, str]
    file: str
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""

    @property
    def place(self) -> str:
        """The file, the line and the tag, with the name if the element has one, for messages."""
        name = f" {quoted(self.attributes['name'])}" if "name" in self.attributes else ""
        return f"{self.file}:{self.line}: <{self.tag}>{name}"

    @contextmanager
    def located(self) -> Iterator[None]:
        """Put the place in front of the message of each HoldfastError in this block that does not name the file yet."""
        try:
            yield
        except HoldfastError as cause:
            if str(cause).startswith(f"{self.file}:"):
                raise
            raise type(cause)(f"{self.place}: {cause}") from cause

    def fail(self, problem: str, remedy: str) -> NoReturn:
        """Raise SceneError about this element."""
        raise SceneError(message(self.place, problem, remedy))

    def all(self, tag: str) -> list[Element]:
        """Return the children with this tag, in the order of the file."""
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> Element | None:
        """Return the child with this tag or None; raises SceneError if there are several."""
        found = self.all(tag)
        if len(found) > 1:
            found[1].fail(f"stands twice in <{self.tag}>", "keep one")
        return found[0] if found else None

    def needed(self, tag: str) -> Element:
        """Return the child with this tag; raises SceneError if there is none, or several."""
        found = self.child(tag)
        return self.fail(f"has no <{tag}>", "add it") if found is None else found

    def attribute(self, name: str) -> str:
        """Return an attribute; raises SceneError if it is missing or blank."""
        value = self.attributes.get(name, "").strip()
        return value or self.fail(f"has no attribute {name!r}", "add it")

    def numbers(self, name: str, count: int, default: tuple[float, ...] | None = None) -> tuple[float, ...]:
        """Return the ``count`` finite numbers of an attribute; ``default`` if missing, or else SceneError."""
        if default is not None and name not in self.attributes:
            return default
        return self._numbers(self.attribute(name), count, f"{name} = ")

    def number(self, name: str, default: float | None = None) -> float:
        """Return the finite number of an attribute; ``default`` if missing, or else SceneError."""
        return self.numbers(name, 1, None if default is None else (default,))[0]

    def values(self, count: int) -> tuple[float, ...]:
        """Return the ``count`` finite numbers that are the text of the element."""
        return self._numbers(self.text, count, "holds ")

    def _numbers(self, text: str, count: int, what: str) -> tuple[float, ...]:
        wanted = f"{count} finite numbers" if count > 1 else f"a finite number of at most {LARGEST:g}"
        try:
            # "0.1, 0, 0", as Bullet and Habitat read it; a comma within a word may stand for a decimal point
            numbers = tuple(float(word.removesuffix(",")) for word in text.split())
        except ValueError:
            numbers = ()
        if len(numbers) != count or not all(abs(number) <= LARGEST for number in numbers) or "_" in text:
            self.fail(f"{what}{quoted(text.strip())}", f"needs {wanted}")
        return numbers


def root_name(text: str) -> str:
    """Return the tag of the outermost element of a text that looks like XML, and an empty text for any other."""
    at = 0
    while found := _BEFORE_ROOT.match(text, at):
        at = found.end()
    root = _ROOT.match(text, at)
    return root.group(1) if root else ""


def without_comments(text: str) -> str:
    """Return an XML text without its comments, with unchanged line numbers.

    XML forbids two hyphens within a comment, but files have them, and the parsers of SDF, URDF and MJCF accept them.
    """

    def blanked(found: re.Match[str]) -> str:
        return found.group() if found.group(1) is None else "\n" * found.group(1).count("\n")

    return _COMMENT.sub(blanked, text)


def parsed(text: str, path: Path) -> Element:
    """Return the outermost element of an XML text.

    A declaration (``<?xml version="0.0" ?>``) is ignored, valid or not, because the text is decoded already. Comments
    are ignored, too. Raises SceneError, with the line, for a document type (which entities and external references
    need), for text that is not XML, and beyond MAX_BYTES, MAX_DEPTH and MAX_ELEMENTS.
    """
    where = str(path)
    if len(text) > MAX_BYTES:
        remedy = f"the limit is {MAX_BYTES:,}: keep meshes in files of their own"
        raise SceneError(message(where, f"is {len(text):,} characters", remedy))
    declaration = _DECLARATION.match(text)
    if declaration is not None:  # keep the line numbers
        text = "\n" * declaration.group().count("\n") + text[declaration.end() :]
    builder = _Builder(where)
    with foreign(where, "is not XML", "check the file"):
        builder.parser.Parse(without_comments(text), True)
    spend(ELEMENTS, builder.count, where)
    assert builder.root is not None  # the parser raises an error if there is no element
    return builder.root


class _Builder:
    """Builds the tree of elements from the events of the parser."""

    def __init__(self, where: str) -> None:
        self.where = where
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0
        self.parser = expat.ParserCreate()
        self.parser.buffer_text = True
        self.parser.StartDoctypeDeclHandler = self.doctype
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters

    def refuse(self, problem: str, remedy: str) -> NoReturn:
        raise SceneError(message(f"{self.where}:{self.parser.CurrentLineNumber}", problem, remedy))

    def doctype(self, *_: object) -> None:
        """Refuse the file before any entity is declared."""
        self.refuse("has a document type (<!DOCTYPE>)", "remove it: entities and outside references are not read")

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(tag, attributes, self.where, self.parser.CurrentLineNumber)
        self.count += 1
        if len(self.open) >= MAX_DEPTH or self.count > MAX_ELEMENTS:
            self.refuse(
                "is nested too deeply or too large", f"the limits are {MAX_DEPTH} levels, {MAX_ELEMENTS:,} elements"
            )
        if self.open:
            self.open[-1].children.append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _: str) -> None:
        self.open.pop()

    def characters(self, text: str) -> None:
        self.open[-1].text += text
