"""A command: `pounding-risk period-ratio SCENE`."""

from itertools import pairwise
from pathlib import Path
from typing import Annotated

import typer


def period_ratio(scene: Annotated[Path, typer.Argument(help="Scene file (.toml).")]) -> None:
    """Period ratio of neighbours."""
    import pounding_risk as pr

    buildings = pr.read_scene(scene).buildings
    for left, right in pairwise(buildings):
        print(f"{left.name} to {right.name}: {left.period / right.period:.3g}")
