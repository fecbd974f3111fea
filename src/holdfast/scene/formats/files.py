"""Load a scene from any known format; save it in the native one."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from holdfast.base.errors import SceneError, located, message
from holdfast.scene.formats import native, published, settled, text
from holdfast.scene.scene import Scene


def load_scene(path: str | Path) -> Scene:
    """Read a scene file: native YAML or JSON, or one of the neutral formats that ``holdfast convert`` takes."""
    path = Path(path)
    with located(str(path)):
        return _scene_from(text.read(path), path)


def _scene_from(data: Any, path: Path) -> Scene:  # noqa: ANN401 - plain data
    for reader in (published, settled):
        if reader.recognises(data):
            scene: Scene = reader.scene_from(data, path)
            return scene
    if not isinstance(data, dict) or "format" not in data:
        remedy = f"a native scene begins with `format: {native.FORMAT}`"
        raise SceneError(message(str(path), "does not say which format it is in", remedy))
    return native.scene_from(data, path)


def save_scene(scene: Scene, path: str | Path) -> None:
    """Write the native file (YAML, or JSON by suffix); ``load_scene`` gives the same scene back, bit for bit."""
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml", ".json"):
        raise SceneError(message(str(path), f"suffix {path.suffix!r}", "needs .yaml, .yml or .json"))
    text.write(path, native.data_from(scene, path))
