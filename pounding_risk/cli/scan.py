"""The command `scan`: a scene's whole grid, by one process, by shards, or by a cluster."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, results_file, writable
from pounding_risk.cli._common.notes import FASTER, print_flags, print_notes, print_unused
from pounding_risk.cli._common.options import NONE, RUN_FAILED, Figure, Overrides, Scene, Strict
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli._common.tables import print_pairs
from pounding_risk.cli.validate import print_plan
from pounding_risk.errors import PoundingError

ORDER = 50
# Options that cannot change a number, and whether they take a value: the results' command is told without them.
ASIDE = {"--workers": True, "--shard": True, "--scheduler": True, "--new": False}

COUNTS = ("cases", "simulated", "known without a run of their own")


def scan(
    scene: Scene,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Results (.nc or .zarr).", show_default="SCENE.nc")
    ] = None,
    overrides: Overrides = NONE,
    screening: Annotated[
        bool, typer.Option("--screening/--no-screening", help="Leave out runs whose answer is known exactly.")
    ] = True,
    check_fraction: Annotated[
        float, typer.Option(help="Share of the runs to make again at a tighter tolerance, 0 to 1.")
    ] = 0.01,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default="one a processor")] = None,
    plan: Annotated[bool, typer.Option("--plan", help="Say what it would take, and run nothing.")] = False,
    shard: Annotated[
        str | None, typer.Option(metavar="I/N", help="Do one part of N, such as 2/8.", show_default=False)
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="Of a Dask cluster that does the work.", show_default=False)
    ] = None,
    new: Annotated[
        bool, typer.Option("--new", help="Discard what an earlier start has kept, and replace other results.")
    ] = False,
    figure: Figure = None,
    strict: Strict = False,
) -> None:
    """Run a scene's whole grid and write one dataset.

    What is done is kept on the way: the same command goes on where it was stopped.
    """
    from pounding_risk.scene.reader import read_scene

    if plan:
        given = {"--shard": shard, "--scheduler": scheduler, "--no-screening": not screening, "--new": new}
        if aside := [option for option, value in given.items() if value]:
            raise PoundingError(
                f"--plan and {aside[0]}: a plan is of the whole scan, screened, on this machine; leave one out"
            )
        from pounding_risk.ensemble.plan.plan import plan as planned

        return print_plan(planned(scene, overrides, workers=workers))
    if shard is not None and (figure is not None or strict):
        option = "--strict" if figure is None else "--figure"
        raise PoundingError(f"{option} and --shard: a shard writes no results; give it to the scan without --shard")
    out_file, figure_file = results_file(scene, out, new), writable("--figure", figure, FIGURES)
    study = read_scene(scene, overrides)
    with Watch("scan" if shard is None else f"shard {shard}", resumes=True) as watch:
        how: dict[str, Any] = {
            "screening": screening,
            "check_fraction": check_fraction,
            "workers": workers,
            "executor": _executor(scheduler, workers),
            "progress": watch,
            "command": command_line(ASIDE),
        }
        if shard is not None:
            return _work_on_shard(study, out_file, shard, new, how)
        from pounding_risk.ensemble.scan import scan as run
        from pounding_risk.results.summary import failures

        start = perf_counter()
        dataset = run(study, out_file, new=new, **how)
    print_scan(dataset, perf_counter() - start, out_file, watch.kept)
    if figure_file is not None:
        from pounding_risk.figures import scan_figure

        draw(scan_figure(dataset), figure_file)
    if strict and failures(dataset):
        raise typer.Exit(RUN_FAILED)


def _executor(scheduler: str | None, workers: int | None) -> Any:
    """A cluster's, where one is named."""
    if scheduler is None:
        return None
    if workers is not None:
        raise PoundingError("--workers and --scheduler: the cluster has workers of its own; name one of the two")
    from pounding_risk.ensemble.dask import Dask

    return Dask(scheduler)


def _work_on_shard(study: Any, out: Path, shard: str, new: bool, how: dict[str, Any]) -> None:
    from pounding_risk.ensemble.scan import scan_shard

    if new:
        raise PoundingError(
            f"--new and --shard: shards share what is kept; remove the folder {out.with_suffix('.study')} to begin anew"
        )
    found = scan_shard(study, out, shard, **how)
    typer.echo(f"shard {shard}: {found.cases} cases done; {found.done} of {found.total} in {found.folder}")
    if found.done == found.total:
        typer.echo(f"every case is done; the same command without --shard writes {out}")


def print_scan(dataset: Any, seconds: float, target: Path, kept: int = 0) -> None:
    """How many cases there were, how they ended, how long it took, and where the results are.

    ``kept`` of them were there when it started.
    """
    from pounding_risk.results.contact_notes import of_results
    from pounding_risk.results.summary import counted, failures
    from pounding_risk.results.tolerance_check import findings

    counts = counted(dataset)
    pairs = [(name, str(counts[name])) for name in COUNTS]
    pairs += [*findings(dataset), *(("failed", f"{count}: {name}") for name, count in failures(dataset).items())]
    rate = (counts["cases"] - kept) / seconds
    speed = f"{rate:.0f}" if rate >= 100.0 else f"{rate:.3g}"
    pairs.append(("time", f"{seconds:.3g} s, {speed} cases a second with reading and compiling"))
    print_pairs([*pairs, ("written", str(target))])
    print_flags(json.loads(dataset.attrs.get("flags", "{}")))
    print_notes(of_results(dataset))
    for sentence in json.loads(dataset.attrs.get("left_out", "[]")):
        print(f"note: left out: {sentence}")
    print_unused(dataset)
    held = int((dataset["restitution_held"] > 0).sum())
    if held:
        print(f"note: {held} cases have contacts {FASTER}")


def command_line(aside: Mapping[str, bool] | None = None) -> str:
    """What was typed, for the results, without the options ``aside``, each of which takes a value or does not.

    Nothing where the command was called from another program. Bytes that are no text are told by their numbers.
    """
    program = Path(sys.argv[0])
    ours = program.stem == "pounding-risk" or (program.name, program.parent.name) == ("__main__.py", "pounding_risk")
    typed = shlex.join(["pounding-risk", *_without(sys.argv[1:], aside or {})]) if ours else ""
    return typed.encode(errors="backslashreplace").decode()


def _without(words: Sequence[str], aside: Mapping[str, bool]) -> list[str]:
    kept, skip = [], False
    for word in words:
        option, has_value, _ = word.partition("=")
        if skip:
            skip = False
        elif option in aside:
            skip = aside[option] and not has_value
        else:
            kept.append(word)
    return kept
