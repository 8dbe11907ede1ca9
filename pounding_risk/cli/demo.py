"""The command `demo`: the pair of the 2011 paper."""

from __future__ import annotations

from pathlib import Path
from time import perf_counter
from typing import Annotated

import typer

from pounding_risk.cli._common.files import check_folder
from pounding_risk.render.terminal import print_pairs

ORDER = 10


Folder = Annotated[Path, typer.Option("--out", "-o", help="Folder for figures and datasets.")]


def demo(out: Folder = Path("pounding-demo")) -> None:
    """Run the pair of the 2011 paper: figures and a dataset."""
    check_folder(out)
    from pounding_risk.reports.demo import demo as run

    start = perf_counter()
    print_pairs((name, str(path)) for name, path in run(out, typer.echo).items())
    typer.echo(f"done in {perf_counter() - start:.1f} s")
