"""The command `cache`: the folder of compiled code, filled beforehand with what scenes need."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.options import NONE, argument
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import print_pairs

ORDER = 225
SHIPPED, SHIPPED_ALL = ("paper", "row"), ("compare", "row")  # of all models `compare` has what each of them needs


def cache(
    scenes: Annotated[list[Path], argument("SCENE...", "Scene files (TOML) to compile for.")] = NONE,
    shipped: Annotated[bool, typer.Option("--shipped", help="Compile for the shipped pair and row.")] = False,
    all_models: Annotated[
        bool, typer.Option("--all-models", help="Compile every contact model that a scene can have.")
    ] = False,
    clear_others: Annotated[
        bool, typer.Option("--clear-others", help="Remove what other versions of the package have compiled.")
    ] = False,
) -> None:
    """Show the cache of compiled code, or fill it for scenes.

    For images and the nodes of a cluster. Without a scene it only says where the folder is and what is in it.
    """
    if all_models and not (scenes or shipped):
        raise PoundingError("--all-models: no scene to compile for; name scene files, or --shipped")
    from pounding_risk.studies.cache import cache as run

    scene_list: list[Any] = [*scenes]
    if shipped:
        from pounding_risk.studies.demo import scene as shipped_scene

        scene_list += map(shipped_scene, SHIPPED_ALL if all_models else SHIPPED)
    with ProgressDisplay("cache", "scenes") as progress:
        state = run(*scene_list, all_models=all_models, clear_others=clear_others, progress=progress)
    print_pairs(state.facts())
    if state.others:
        print("\n--clear-others removes the folders of other versions.")
