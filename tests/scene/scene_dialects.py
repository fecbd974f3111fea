"""Small inputs in the dialects of public scene sets, as data in ``dialects/``, and the table of what becomes of them.

Each file there names a source and holds inputs that were written after real files of it: what an input shows, its
text with the files beside it, the options, and what must come of it. ``python -m tests.scene.scene_dialects`` writes
the table, docs/reference/dialects.md.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

import holdfast as hf

FOLDER = Path(__file__).parent / "dialects"
TABLE = Path(__file__).parents[2] / "docs" / "reference" / "dialects.md"
FOLDERS = ("model_path", "package", "within")  # options that name folders, here relative to the root of an input
PLACES = ("poses",)  # options that hold poses, here positions
HEAD = """# Public scene files

For people who use a public scene set: what of it is read, with which options of `hf.load_scene`, and what is refused.
Files of these sets are not in this repository: each row is about small inputs of our own that imitate them, in
`tests/scene/dialects/`. `python -m tests.scene.scene_dialects` writes the table, and a test compares it.

| source | read | refused → what to do |
|---|---|---|
"""


@dataclass
class Input:
    """One input: its text and the files beside it by name, options, and what is expected."""

    source: str
    file: str
    shows: str
    text: str
    beside: dict[str, str] = field(default_factory=dict)
    options: dict[str, Any] = field(default_factory=dict)
    expected: dict[str, Any] = field(default_factory=dict)

    def written(self, folder: Path) -> Path:
        """Write the input and all that lies beside it; return its path."""
        for name, content in {**self.beside, self.file: self.text}.items():
            path = folder / "set" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            shared = FOLDER / content
            path.write_text(shared.read_text() if "\n" not in content and shared.is_file() else content)
        return folder / "set" / self.file

    def loaded(self, path: Path) -> hf.Scene:
        """Load the input that was written at ``path``."""
        options = {
            name: self._folder(path, value) if name in FOLDERS else value for name, value in self.options.items()
        }
        options |= {name: {k: hf.pose(*at) for k, at in options[name].items()} for name in PLACES if name in options}
        return hf.load_scene(path, **options)

    def _folder(self, path: Path, value: Any) -> Any:
        root = path
        for _ in Path(self.file).parts:
            root = root.parent
        if isinstance(value, dict):
            return {name: root / each for name, each in value.items()}
        return [root / each for each in value] if isinstance(value, list) else root / value


def inputs() -> list[Input]:
    """All inputs, in the order of their sources."""
    found = []
    for path in sorted(FOLDER.glob("*.yaml")):
        data = yaml.safe_load(path.read_text())
        texts: dict[str, str] = {}
        for each in data["inputs"]:
            given = dict(each)
            if "same" in given:
                given["text"] = texts[given.pop("same")]
            texts.setdefault(given["file"], given["text"])
            taken = [given.pop(name) for name in ("file", "shows", "text")]
            beside, options = given.pop("with", {}), given.pop("options", {})
            found.append(Input(data["source"], *taken, beside, options, given))
    return found


def table() -> str:
    """The table of all sources: what of each is read, with which options, and what is refused."""
    rows: dict[str, tuple[list[str], list[str]]] = {}
    for each in inputs():
        taken, refused = rows.setdefault(each.source, ([], []))
        options = ", ".join(f"{key}={value!r}" for key, value in each.options.items())
        with TemporaryDirectory() as name, warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                each.loaded(each.written(Path(name)))
                taken.append(f"`{each.file}`" + (f" (`{options}`)" if options else ""))
            except hf.HoldfastError as error:
                found, remedy = str(error), "in no format that is read"
                if "can be read: " not in found:
                    remedy = found.rpartition("; ")[2].replace(f"{name}/set", ".")
                refused.append(f"{each.shows} → {remedy}")
    cells = [(source, ", ".join(dict.fromkeys(taken)), "; ".join(refused)) for source, (taken, refused) in rows.items()]
    lines = [" | ".join(text.replace("|", "/").replace("<", "&lt;") for text in row) for row in cells]
    return HEAD + "".join(f"| {line} |\n" for line in lines)


if __name__ == "__main__":
    TABLE.write_text(table())
