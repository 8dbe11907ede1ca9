"""The command `scan`: a scene's whole grid, run by one process, by shards, or by a cluster."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer

from pounding_risk.cli._common import options as shared
from pounding_risk.cli._common.files import draw, out_or
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli.validate import print_plan
from pounding_risk.errors import PoundingError
from pounding_risk.questions.notes import FASTER, of_records
from pounding_risk.render.terminal import print_left_out, print_notes, print_pairs

ORDER = 50
# Options that cannot change a number, and whether they take a value: left out of the command that the results carry.
NO_INFLUENCE = {"--workers": True, "--shard": True, "--scheduler": True, "--new": False}
COUNTS = ("cases", "simulated", "known without a run of their own")
AGAIN = "to make the same study again, --new to replace it whatever it is, or -o and another name"


def scan(
    scene: shared.Scene,
    out: Annotated[Path | None, shared.out_option("Results", ".nc", ".zarr", absence="SCENE.nc")] = None,
    overrides: shared.Overrides = shared.NONE,
    samples: Annotated[int | None, shared.option("Of the uncertain numbers, in place of the scene's.", min=0)] = None,
    screening: Annotated[
        bool, typer.Option("--screening/--no-screening", help="Leave out runs whose answer is known exactly.")
    ] = True,
    check_fraction: Annotated[
        float, shared.option("Share of the runs to make again at a tighter tolerance, 0 to 1.")
    ] = 0.01,
    workers: shared.Workers = None,
    plan: Annotated[bool, typer.Option("--plan", help="Say what it would take, and run nothing.")] = False,
    shard: Annotated[str | None, shared.option("Do one part of N, such as 2/8.", metavar="I/N")] = None,
    scheduler: Annotated[str | None, shared.option("Of a Dask cluster that does the work.", metavar="ADDRESS")] = None,
    new: Annotated[
        bool, typer.Option("--new", help="Discard what an earlier start has kept, and replace other results.")
    ] = False,
    figure: shared.Figure = None,
    strict: shared.Strict = False,
) -> None:
    """Run a scene's whole grid and write one dataset.

    What is done is kept on the way: the same command goes on where it was stopped.
    """
    overrides = overrides if samples is None else [*overrides, f"uncertain.samples={samples}"]
    if plan:
        excluded = {"--shard": shard, "--scheduler": scheduler, "--no-screening": not screening, "--new": new}
        for option in (option for option, value in excluded.items() if value):
            raise PoundingError(
                f"--plan and {option}: a plan is of the whole scan, screened, on this machine; leave one out"
            )
        from pounding_risk.ensemble.plan.plan import plan as planned

        return print_plan(planned(scene, overrides, workers=workers))
    if shard is not None and (figure is not None or strict):
        option = "--strict" if figure is None else "--figure"
        raise PoundingError(f"{option} and --shard: a shard writes no results; give it to the scan without --shard")
    from pounding_risk.ensemble.scan import scan as run
    from pounding_risk.results.summary import failures
    from pounding_risk.scene.reader import read_scene

    study = read_scene(scene, overrides)
    target = out_or(out, f"{scene.stem}.nc", AGAIN, replace=new)
    with ProgressDisplay("scan" if shard is None else f"shard {shard}", resumes=True) as progress:
        choices: dict[str, Any] = {
            "screening": screening,
            "check_fraction": check_fraction,
            "workers": workers,
            "executor": _executor(scheduler, workers),
            "progress": progress,
            "command": command_line(NO_INFLUENCE),
        }
        if shard is not None:
            return _scan_shard(study, target, shard, new, choices)
        start = perf_counter()
        dataset = run(study, target, new=new, **choices)
    print_scan(dataset, perf_counter() - start, target, progress.n_earlier)
    draw(figure, "of_results.results_figure", dataset)
    if strict and failures(dataset):
        raise typer.Exit(shared.RUN_FAILED)


def _executor(scheduler: str | None, workers: int | None) -> Any:
    """The executor of the Dask cluster at an address; None where no address is given."""
    if scheduler is None:
        return None
    if workers is not None:
        raise PoundingError("--workers and --scheduler: the cluster has workers of its own; name one of the two")
    from pounding_risk.ensemble.dask import Dask

    return Dask(scheduler)


def _scan_shard(study: Any, out: Path, shard: str, new: bool, choices: dict[str, Any]) -> None:
    """Run the cases of one shard, such as "2/8", and print how many of the whole grid are done."""
    from pounding_risk.ensemble.scan import scan_shard

    if new:
        raise PoundingError(
            f"--new and --shard: shards share what is kept; remove the folder {out.with_suffix('.study')} to begin anew"
        )
    state = scan_shard(study, out, shard, **choices)
    typer.echo(f"shard {shard}: {state.cases} cases done; {state.done} of {state.total} in {state.folder}")
    if state.done == state.total:
        typer.echo(f"every case is done; the same command without --shard writes {out}")


def print_scan(dataset: Any, seconds: float, target: Path, n_earlier: int = 0) -> None:
    """Print how many cases there were, how they ended, the time taken, the file, and notes.

    ``n_earlier`` of the cases were done by an earlier start, and do not count in the speed.
    """
    from pounding_risk.results.opened import Results
    from pounding_risk.results.summary import counted, failures
    from pounding_risk.results.tolerance_check import findings
    from pounding_risk.results.variables import NOT_RUN

    counts = counted(dataset)
    pairs = [(name, str(counts[name])) for name in (*COUNTS, NOT_RUN) if name in counts]
    pairs += [*findings(dataset), *(("failed", f"{count}: {name}") for name, count in failures(dataset).items())]
    rate = (counts["cases"] - n_earlier) / seconds
    speed = f"{rate:.0f}" if rate >= 100.0 else f"{rate:.3g}"
    words = f"{speed} cases a second with reading and compiling" if rate else "every case was done before"
    pairs.append(("time", f"{seconds:.3g} s, {words}"))
    print_pairs([*pairs, ("written", str(target))])
    flags, left_out, unused = (
        json.loads(dataset.attrs.get(name, "{}")) for name in ("flags", "left_out", "unused_keys")
    )
    print_notes((*of_records(flags), *Results(dataset).notes))
    print_left_out(left_out)
    n_held = int((dataset["restitution_held"] > 0).sum())
    held_note = f"{n_held} case{' has' if n_held == 1 else 's have'} contacts {FASTER}"
    print_notes([*unused, *([held_note] if n_held else [])])


def command_line(excluded: Mapping[str, bool]) -> str:
    """The command as it was typed, without the options ``excluded``, each of which takes a value or does not.

    "" where the function was called from another program. Bytes that are not text are escaped.
    """
    program = Path(sys.argv[0])
    if program.stem != "pounding-risk" and (program.name, program.parent.name) != ("__main__.py", "pounding_risk"):
        return ""
    return shlex.join(["pounding-risk", *_without(sys.argv[1:], excluded)]).encode(errors="backslashreplace").decode()


def _without(words: Sequence[str], excluded: Mapping[str, bool]) -> list[str]:
    """Words of a command without some options and their values."""
    remaining, is_value = [], False
    for word in words:
        option, equals, _ = word.partition("=")
        if is_value:
            is_value = False
        elif option in excluded:
            is_value = excluded[option] and not equals
        else:
            remaining.append(word)
    return remaining
