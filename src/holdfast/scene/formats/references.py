"""The files that a scene file names: found beside it or in packages, and never outside of these folders."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import unquote

from holdfast.base.arrays import checked_mapping
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.text import quoted

Packages = Mapping[str, str | Path] | Callable[[str], str | Path | None]

MANIFESTS = ("package.xml", "model.config")  # a folder that holds one of these is a package of its folder's name


@dataclass(frozen=True)
class References:
    """Resolves names of files for the scene file at ``path``.

    ``packages`` maps names of packages to folders, or is a function that does. A name may lead to the folder of the
    scene file, to a package, and to what lies in them; ``option`` is the keyword of ``load_scene`` that widens this.
    """

    path: Path
    packages: Packages | None
    option: str = "package"

    def __post_init__(self) -> None:
        if self.packages is not None and not callable(self.packages):
            checked_mapping(self.packages, self.option, '{"robot": "folder"}')

    def file(self, name: str, where: str) -> Path:
        """Return the path of the file with this name: relative, absolute, ``file://``, ``package://``, ``model://``.

        Raises SceneError for another scheme, an unknown package, or a path out of the folders that may be read.
        """
        scheme, split, rest = name.partition("://")
        if not split:
            return self._inside(self.path.parent / name, [self.path.parent, *self._folders()], name, where)
        if scheme == "file":
            return self._inside(self.path.parent / unquote(rest), [self.path.parent, *self._folders()], name, where)
        if scheme not in ("package", "model"):
            raise SceneError(message(where, f"names {quoted(name)}", "needs a path, file://, package:// or model://"))
        package, _, inner = unquote(rest).partition("/")
        folder = self.package(package, where)
        return self._inside(folder / inner, [folder], name, where)

    def package(self, name: str, where: str) -> Path:
        """Return the folder of a package: as given, or the nearest folder above of this name with a manifest in it."""
        given = self.packages(name) if callable(self.packages) else (self.packages or {}).get(name)
        if given is not None:
            return Path(given)
        here = Path(os.path.abspath(self.path)).parent
        for folder in (here, *here.parents):
            if folder.name == name and any((folder / each).is_file() for each in MANIFESTS):
                return folder
        known = [] if callable(self.packages) or not self.packages else list(self.packages)
        hint = f"{nearest_of(name, known)} " if known else ""
        remedy = f"{hint}give {self.option}={{{quoted(name)}: folder}}"
        raise SceneError(message(where, f"names the package {quoted(name)}, whose folder is unknown", remedy))

    def _folders(self) -> list[Path]:
        return [] if callable(self.packages) or not self.packages else [Path(each) for each in self.packages.values()]

    def _inside(self, path: Path, folders: list[Path], name: str, where: str) -> Path:
        """Return ``path`` if, behind all links, it lies in one of the folders."""
        try:
            real = Path(os.path.realpath(path))
            inside = any(real.is_relative_to(os.path.realpath(folder)) for folder in folders)
        except (OSError, ValueError) as cause:  # a zero byte, a circle of links
            raise SceneError(message(where, f"names {quoted(name)}: {cause}", "check the path")) from cause
        if not inside:
            remedy = f"move it there, or give its folder with {self.option}={{name: folder}}"
            raise SceneError(message(where, f"names {quoted(name)}, outside of the folder of the file", remedy))
        return path
