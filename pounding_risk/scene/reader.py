"""Scene files: TOML with quantities in, a `Scene` out, and every fault of a file at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pounding_risk.errors import SceneError
from pounding_risk.scene.scene import Scene, scene_of
from pounding_risk.scene.sections import overridden
from pounding_risk.scene.toml import key_lines, parse_toml, read_text
from pounding_risk.units import shown


def read_scene(scene: str | Path | Mapping[str, Any], overrides: Sequence[str] = ()) -> Scene:
    """The scene of a file, of a text or of a dict, with ``--set``-like ``overrides`` ('interface.gap="20 mm"') applied.

    Parameters
    ----------
    scene : str, path or mapping
        A scene file; the text of one, which has several lines; or its tables, with its keys and quantities as text.
        Record files are relative to the scene file's folder, to the working folder of a text or of tables.
    overrides : sequence of str
        Keys set from outside, one `path=value` each.

    Returns
    -------
    Scene
        The scene with every number in SI and every default filled in.

    Raises
    ------
    SceneError
        With every fault: its line, its key and the likely repair.
    """
    if isinstance(scene, Mapping):
        return scene_of(scene, overrides=overrides)
    if isinstance(scene, str) and ("\n" in scene or "[[" in scene):
        return parse_scene(scene, overrides=overrides)
    if not isinstance(scene, str | Path):
        raise SceneError(
            "scene", [f"{shown(scene)} is no scene; give the name of a scene file, its text, or its tables (a dict)"]
        )
    path = Path(scene)
    return parse_scene(read_text(path), str(path), overrides)


def parse_scene(text: str, source: str = "scene", overrides: Sequence[str] = ()) -> Scene:
    """The scene of a TOML text. As `read_scene`; record files are relative to ``source``'s folder."""
    return scene_of(parse_toml(text, source), source, overrides, text=text, lines=key_lines(text))


def written_tables(scene: Scene) -> dict[str, Any]:
    """The tables of a scene's text with its overrides, as they were written; its resolved ones where it has no text."""
    if not scene.text:
        return scene.resolved()
    return overridden(parse_toml(scene.text, scene.source), scene.overrides, scene.source)


def as_scene(scene: Scene | Mapping[str, Any] | str | Path) -> Scene:
    """A scene as it is, or read from a file, a text or tables."""
    return scene if isinstance(scene, Scene) else read_scene(scene)
