"""A scene file that is being read; each part of it is read and parsed at most once."""

from __future__ import annotations

from codecs import BOM_UTF8
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from holdfast.base.borders.foreign import JSON, YAML, foreign, spend
from holdfast.base.errors import SceneError, message
from holdfast.base.files import check_ordinary, read_ordinary
from holdfast.base.text import listed, quoted
from holdfast.scene.formats import plain_data

MAX_BYTES = 200_000_000  # size of the largest file that is read
MAX_JSON_BYTES = 32_000_000  # size of the largest JSON file; parsed data may take twenty times the memory
HEAD_BYTES = 4096  # length of the first part of a file, by which its format is recognised


@dataclass(frozen=True, eq=False)
class Source:
    """The file at ``path`` as the formats see it: its first bytes and, on demand, its content, text and data.

    A part that does not exist raises SceneError: a binary file has no text, and a text that is neither JSON nor YAML
    has no data. If ``given`` holds the content, no file is read, and ``path`` is its name: paths in it are relative to
    the folder of that name.
    """

    path: Path
    given: bytes | None = None

    def __post_init__(self) -> None:
        if self.given is None:
            check_ordinary(self.path, "scene file")

    @cached_property
    def suffix(self) -> str:
        """The suffix of the file in lower case, with its dot; empty if there is none."""
        return self.path.suffix.lower()

    @cached_property
    def head(self) -> bytes:
        """The first 4,096 bytes of the file, or all bytes of a shorter one."""
        if self.given is not None:
            return self.given[:HEAD_BYTES]
        try:
            with self.path.open("rb") as stream:
                return stream.read(HEAD_BYTES)
        except OSError as cause:
            problem = f"cannot be read: {cause.strerror or cause}"
            raise SceneError(message(str(self.path), problem, "needs a file that may be read")) from cause

    @cached_property
    def content(self) -> bytes:
        """All bytes of the file."""
        return read_ordinary(self.path, "scene file", most=MAX_BYTES) if self.given is None else self.given

    @cached_property
    def text(self) -> str:
        """The content decoded as UTF-8, without a byte-order mark."""
        remedy = "needs a readable UTF-8 text file"
        if b"\0" in self.head:  # checked before a large file is read
            raise SceneError(message(str(self.path), "cannot be read: has zero bytes, which no text has", remedy))
        with foreign(str(self.path), remedy=remedy):
            return self.content.decode("utf-8-sig")

    @property
    def data(self) -> Any:  # noqa: ANN401 - plain data
        """The text parsed as JSON or YAML: dicts, lists and scalars.

        All formats share this object and must not change it.
        """
        data, error = self._parsed
        if error is not None:
            raise error
        return data

    @cached_property
    def _parsed(self) -> tuple[Any, SceneError | None]:
        """The data, or the error if there is none; errors are cached, too, so that parsing is tried only once."""
        try:
            size = self._check_size(MAX_JSON_BYTES if self._is_json else plain_data.MAX_YAML)
            spend(JSON if self._is_json else YAML, size, str(self.path))
            if self._is_json:
                return plain_data.from_json(self.text, str(self.path)), None
            return plain_data.from_yaml(self.text, str(self.path)), None
        except SceneError as error:
            return None, error

    @property
    def _is_json(self) -> bool:
        """Whether the file is parsed as JSON, by its suffix or, if that is inconclusive, its first character."""
        if self.suffix in plain_data.SUFFIXES:
            return self.suffix == ".json"
        return self.head.removeprefix(BOM_UTF8).lstrip()[:1] in (b"{", b"[")

    def _check_size(self, limit: int) -> int:
        size = check_ordinary(self.path, "scene file") if self.given is None else len(self.given)
        if size > limit:
            remedy = f"the limit is {limit:,}: keep meshes in files of their own"
            raise SceneError(message(str(self.path), f"is {size:,} bytes", remedy))
        return size

    def described(self) -> str:
        """Describe the content in a few words, for the error message if no format recognises it."""
        if not self.head:
            return "empty"
        data, error = self._parsed
        if error is not None or isinstance(data, str):
            return f"first bytes {self.head[:16]!r}"
        if not isinstance(data, dict) or not data:
            return f"only {quoted(data, 40)}"
        if "format" in data:
            return f"`format` is {quoted(data['format'], 40)}"
        return f"no `format` among its keys {listed([quoted(key, 40) for key in data], 3)}"
