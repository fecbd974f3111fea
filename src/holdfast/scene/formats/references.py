"""Files that a scene file refers to: they must be in its folder, in ``../meshes`` or in packages, never elsewhere."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from urllib.parse import unquote

from holdfast.base.arrays import checked_items, checked_mapping
from holdfast.base.errors import SceneError, message, nearest_of
from holdfast.base.files import checked_path, read_ordinary
from holdfast.base.text import quoted
from holdfast.scene.xml import MAX_BYTES, parsed

Packages = Mapping[str, str | Path] | Callable[[str], str | Path | None]

ROS = "package.xml"  # a manifest that contains the name of its package
MANIFESTS = (ROS, "model.config")  # a folder that contains one of these is a package
VARIABLES = ("GZ_SIM_RESOURCE_PATH", "GAZEBO_MODEL_PATH")  # in which Gazebo looks for folders of models
# an address of a model, or of a file of it, among those that Gazebo fetches
FUEL = re.compile(
    r"https?://(?:[\w-]+\.)*(?:gazebosim|ignitionrobotics)\.org/(?:[\d.]+/)?[^/]+/models/([^/]+)(?:/\d+|/tip)?(?:/files)?(?:/(.*))?"
)
BESIDE = re.compile(r"\.\./(mesh[\w-]*)/")  # a folder of meshes beside that of a file, as packages of ROS have it
MODELS = "models/"  # folder of models in the addresses of files that Gazebo looks for in all of its folders


@dataclass(frozen=True)
class References:
    """Resolves names of files for the scene file at ``path``.

    ``packages`` maps names of packages to folders, or is a function that does. Files must be in the folder of the scene
    file, in a folder of meshes beside it (``../meshes``), in a package or in one of ``models``. ``option`` is the
    keyword of ``load_scene`` that allows further folders, for error messages. ``models`` are folders of models: a
    package or model, also one of Gazebo's at an address, may be a folder in them.
    """

    path: Path
    packages: Packages | None
    option: str = "package"
    models: tuple[Path, ...] = ()
    _found: dict[str, Path] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if self.packages is not None and not callable(self.packages):
            checked_mapping(self.packages, self.option, '{"robot": "folder"}')

    def beside(self, path: Path) -> References:
        """Return the references of another file, which looks in the same packages and folders."""
        return replace(self, path=path)

    def file(self, name: str, where: str) -> Path:
        """Return the path of the file with this name: relative, absolute, ``file://``, ``package://``, ``model://``.

        The address of a model of Gazebo counts as ``model://`` and its name. So does ``file://models/`` and its name
        where there is no such file.

        Raises SceneError for another scheme, an unknown package, or a path outside the folders that may be read.
        """
        fetched = FUEL.fullmatch(name)
        if fetched:
            return self.file(f"model://{fetched[1]}/{fetched[2] or ''}", where)
        scheme, split, rest = name.partition("://")
        if not split or scheme == "file":
            path = self.path.parent / (unquote(rest) if split else name)
            if split and rest.startswith(MODELS) and not os.path.exists(path):
                return self.file(f"model://{rest.removeprefix(MODELS)}", where)
            found = BESIDE.match(name)
            beside = None if found is None else self.path.parent / ".." / found[1]
            folders = [] if beside is None or os.path.islink(beside) else [beside]
            if not callable(self.packages) and self.packages:
                folders += map(Path, self.packages.values())
            return self._inside(path, [self.path.parent, *folders, *self.models], name, where)
        if scheme not in ("package", "model"):
            raise SceneError(message(where, f"names {quoted(name)}", "needs a path, file://, package:// or model://"))
        package, _, inner = unquote(rest).partition("/")
        folder = self.package(package, where)
        return self._inside(folder / inner, [folder], name, where)

    def package(self, name: str, where: str) -> Path:
        """Return the folder of a package: as given, or the nearest one with a manifest and this name.

        The folders beside the file, above it, and beside its own folder are searched. The name of a package is that in
        package.xml, or else that of its folder.
        """
        found = self.known_package(name)
        if found is not None:
            return found
        known = [] if callable(self.packages) or not self.packages else list(self.packages)
        hint = f"{nearest_of(name, known)} " if known else ""
        remedy = f"{hint}give {self.option}={{{quoted(name)}: folder}}"
        if self.option == "package":
            remedy += ", or model_path=[the folder in which it lies]"
        raise SceneError(message(where, f"names the package {quoted(name)}, whose folder is unknown", remedy))

    def known_package(self, name: str) -> Path | None:
        """Return the folder of a package like ``package``; None if it is unknown."""
        given = self.packages(name) if callable(self.packages) else (self.packages or {}).get(name)
        if given is not None:
            return Path(given)
        if name in self._found:
            return self._found[name]
        here = Path(os.path.abspath(self.path)).parent
        is_name = name not in ("", ".", "..")
        for models in self.models if is_name else ():
            if os.path.isdir(models / name):  # False for a name that is too long
                return models / name
        for folder in (*_folders_in(here), here, *here.parents, *([here.parent / name] if is_name else [])):
            if _is_package(folder, name):
                self._found[name] = folder
                return folder
        return None

    def _inside(self, path: Path, folders: list[Path], name: str, where: str) -> Path:
        """Return ``path`` if it is in one of the folders after resolving all links."""
        try:
            real = Path(os.path.realpath(path))
            inside = any(real.is_relative_to(os.path.realpath(folder)) for folder in folders)
        except (OSError, ValueError) as cause:  # for example a null byte or a cycle of links
            raise SceneError(message(where, f"names {quoted(name)}: {cause}", "check the path")) from cause
        if not inside:
            remedy = f"move it there, or give a folder that holds it with {self.option}={{name: folder}}"
            raise SceneError(message(where, f"names {quoted(name)}, outside of the folder of the file", remedy))
        return path


def model_folders(given: Iterable[str | Path] | None, notes: list[str]) -> tuple[Path, ...]:
    """Check the option ``model_path`` of readers, and add the folders of Gazebo's variables of the environment, noted.

    Raises SceneError unless it is a list of folders.
    """
    listed_ = [] if given is None else checked_items(given, "model_path", 'folders, as ["models"]')
    folders = [checked_path(each, "model_path") for each in listed_]
    for folder in folders:
        if not folder.is_dir():
            raise SceneError(message("model_path", f"{quoted(str(folder), 120)} is no folder", "check the path"))
    for variable in VARIABLES:
        more = [Path(each) for each in os.environ.get(variable, "").split(os.pathsep) if each and Path(each).is_dir()]
        if more:
            notes.append(f"models are also looked for in {variable}: {os.pathsep.join(map(str, more))}")
        folders += more
    return tuple(folders)


def _folders_in(folder: Path) -> list[Path]:
    try:
        return sorted(each for each in folder.iterdir() if each.is_dir() and not each.is_symlink())
    except OSError:  # a folder that may not be listed
        return []


def _is_package(folder: Path, name: str) -> bool:
    """Tell whether a folder is the package of this name, by its manifest, or by its own name with a manifest in it."""
    if folder.name == name:
        return any(os.path.isfile(folder / each) for each in MANIFESTS)
    if not (folder / ROS).is_file():
        return False
    try:
        content = read_ordinary(folder / ROS, ROS, most=MAX_BYTES).decode("utf-8", "replace")
        return any(child.text.strip() == name for child in parsed(content, folder / ROS).all("name"))
    except SceneError:  # a damaged manifest of another package
        return False
