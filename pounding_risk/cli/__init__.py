"""The command line: each command reads its options, makes one call of the Python API, and prints what came of it.

Everything but typer is imported when a command runs, so that help and completion answer at once.
"""

from __future__ import annotations

import os
import sys
import threading
from contextlib import suppress
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any

import typer
from typer.core import TyperGroup

from pounding_risk.cli._common.compile_cache import cache_told
from pounding_risk.cli._common.options import (
    BAD_INPUT,
    FIGURES,
    INTERRUPTED,
    RUN_FAILED,
    Blow,
    Figure,
    New,
    Overrides,
    Scene,
    Strict,
    check_folder,
    contact_laws,
    floors,
    read_option,
    writable,
)
from pounding_risk.cli._common.tables import draw
from pounding_risk.cli.assess import assess
from pounding_risk.cli.block import block
from pounding_risk.cli.draw import draw as draw_row
from pounding_risk.cli.histories import histories
from pounding_risk.cli.models import models
from pounding_risk.cli.modes import modes
from pounding_risk.cli.records import records_app
from pounding_risk.cli.report import report
from pounding_risk.cli.rerun import rerun
from pounding_risk.cli.scan import scan
from pounding_risk.cli.separations import separations
from pounding_risk.cli.status import status
from pounding_risk.cli.summary import convert, summary
from pounding_risk.cli.view import view
from pounding_risk.errors import PoundingError

NONE: list[str] = []


class Commands(TyperGroup):
    """The commands; what a user can repair is told in sentences, without a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command; bad input ends with status 2, Ctrl-C with 130."""
        try:
            with cache_told():
                return super().invoke(ctx)
        except PoundingError as error:
            typer.echo(f"pounding-risk: {error}", err=True)
            raise typer.Exit(BAD_INPUT) from None
        except OSError as error:  # a name too long, a full disk: a fault of no code, wherever it shows
            if error.filename is None:
                raise
            typer.echo(f"pounding-risk: {error.filename}: {error.strerror}; choose another name or place", err=True)
            raise typer.Exit(BAD_INPUT) from None
        except KeyboardInterrupt as stop:
            kept = str(stop) or "no file was left half written"
            typer.echo(f"pounding-risk: stopped by Ctrl-C; {kept}", err=True)
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(cls=Commands, no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)
app.add_typer(records_app, name="records")


def main() -> None:
    """Entry point of ``pounding-risk``."""
    try:
        app(prog_name="pounding-risk")
    except SystemExit as end:
        _leave(end)
        raise
    except KeyboardInterrupt:  # before a command is reached, or a second one on the way out
        _leave(SystemExit(INTERRUPTED))
        sys.exit(INTERRUPTED)


def _leave(end: SystemExit) -> None:
    """Be gone at once where threads are still in a kernel, which nobody waits for and which cannot be interrupted.

    Python would take its interpreter down below them.
    """
    if "pounding_risk.ensemble.threads" not in sys.modules:
        return
    from pounding_risk.ensemble.threads import WORKER

    if not any(thread.daemon and thread.name.startswith(WORKER) for thread in threading.enumerate()):
        return
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError):  # a pipe that nobody reads any more
            stream.flush()
    os._exit(end.code if isinstance(end.code, int) else int(end.code is not None))


def _version(asked: bool) -> None:
    if asked:
        from pounding_risk import __version__

        typer.echo(f"pounding-risk {__version__}")
        raise typer.Exit


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and stop.")
    ] = False,
) -> None:
    """Seismic pounding of adjacent buildings: is this gap enough, and what gap would be?

    Quantities have units: "44.36 t", "25 mm", "0.5 g". In a shell, quote them.
    """


@app.command()
def demo(out: Annotated[Path, typer.Option(help="Folder for figures and datasets.")] = Path("pounding-demo")) -> None:
    """Run the pair of the 2011 paper: figures and a dataset."""
    check_folder(out)
    from pounding_risk.cli._common.tables import print_pairs
    from pounding_risk.reports.demo import demo as run

    start = perf_counter()
    written = run(out, typer.echo)
    print_pairs((name, str(path)) for name, path in written.items())
    typer.echo(f"done in {perf_counter() - start:.1f} s")


@app.command()
def validate(scene: Scene, overrides: Overrides = NONE) -> None:
    """Check a scene and its records; run nothing."""
    from pounding_risk.cli.simulate import print_plan
    from pounding_risk.ensemble.plan.plan import validate as run

    print_plan(run(scene, overrides))


@app.command()
def impact(
    law: Annotated[list[str], typer.Option(help="Contact model; repeat to compare.")] = ["jankowski"],  # noqa: B006
    stiffness: Annotated[
        list[str], typer.Option(help="β in N/m^1.5 or k in N/m; one of each where laws of both kinds are compared.")
    ] = ["2.75e9 N/m^1.5"],  # noqa: B006
    mass: Annotated[str, typer.Option(help="Mass of the striker.")] = "570 kg",
    other_mass: Annotated[str, typer.Option(help="Mass that is struck; inf is a fixed wall.")] = "inf",
    speed: Annotated[str, typer.Option(help="Speed of approach.")] = "0.5 m/s",
    restitution: Annotated[
        str, typer.Option(help="Coefficient e in (0, 1], concrete, or 'xi 0.35 of jankowski'.")
    ] = "0.65",
    relation: Annotated[str, typer.Option(help="Damping from e: published, or exact.")] = "published",
    yield_force: Annotated[str, typer.Option(help="F_E, for laws with a cap; inf never yields.")] = "inf",
    floor_length: Annotated[
        str | None, typer.Option(help="Length of the striker's floor, for distributed_mass.", show_default=False)
    ] = None,
    other_floor_length: Annotated[
        str | None, typer.Option(help="Length of the floor that is struck.", show_default=False)
    ] = None,
    wave_speed: Annotated[str, typer.Option(help="Wave speed of both floors.")] = "3500 m/s",
    figure: Figure = None,
) -> None:
    """Let two bodies collide once under each contact model."""
    target = writable("--figure", figure, FIGURES)
    from pounding_risk.cli.simulate import FASTER, print_impacts
    from pounding_risk.studies.impact import impact as run
    from pounding_risk.studies.impact import restitution_of
    from pounding_risk.units import MASS, SPEED, YIELD_FORCE

    striker = read_option("--mass", mass, MASS)
    struck = read_option("--other-mass", other_mass, MASS._replace(open_high=False))
    fast = read_option("--speed", speed, SPEED)
    strength = read_option("--yield-force", yield_force, YIELD_FORCE)
    rule = restitution_of(restitution)
    reduced = 1.0 / (1.0 / striker + 1.0 / struck)
    slabs = floors(floor_length, other_floor_length, wave_speed)
    laws, notes = contact_laws(law, stiffness, Blow(fast, reduced, rule, slabs, struck == inf), relation)
    found = [run(each, fast, striker, struck, restitution=rule, yield_force=strength) for each in laws]
    print_impacts(found, laws, 0.5 * reduced * fast**2)
    if rule.beyond(fast):
        notes.append(f"note: the approach is {FASTER}")
    for note in notes:
        typer.echo(note)
    if target is not None:
        from pounding_risk.figures import impact_figure

        draw(impact_figure(found), target)


@app.command()
def simulate(
    scene: Scene,
    overrides: Overrides = NONE,
    record: Annotated[str | None, typer.Option(help="A record of the scene.", show_default="its first")] = None,
    polarity: Annotated[str | None, typer.Option(help="as recorded, or reversed.", show_default="its first")] = None,
    law: Annotated[str | None, typer.Option(help="Contact model.", show_default="the interface's")] = None,
    gap: Annotated[str | None, typer.Option(help="Clear distance at rest.", show_default="the interface's")] = None,
    yield_force: Annotated[str | None, typer.Option(help="F_E, or inf.", show_default="the interface's")] = None,
    pga: Annotated[str | None, typer.Option(help="Peak ground acceleration.", show_default="the first")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write histories (.nc).", show_default=False)] = None,
    figure: Figure = None,
    animation: Annotated[Path | None, typer.Option(help="A row's run, moving (.html).", show_default=False)] = None,
    strict: Strict = False,
) -> None:
    """Run one case in full: outputs, contacts, histories."""
    dataset_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    moving = writable("--animation", animation, (".html",))
    from pounding_risk.cli.simulate import print_run
    from pounding_risk.cli.simulate_row import check_moving, move
    from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable
    from pounding_risk.results.files import save
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.simulate import simulate as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    asked = (("gap", gap, GAP), ("yield_force", yield_force, YIELD_FORCE), ("pga", pga, PGA))
    values = {
        name: read_option(f"--{name.replace('_', '-')}", text, quantity)
        for name, text, quantity in asked
        if text is not None
    }
    study = check_moving(read_scene(scene, overrides), moving)
    if dataset_file is not None:
        check_replaceable(dataset_file, "simulate", choice=OTHER_NAME)
    dataset = run(study, record=record, polarity=polarity, law=law, **values)
    print_run(dataset)
    if dataset_file is not None:
        save(dataset, dataset_file)
        typer.echo(f"written: {dataset_file}")
    if figure_file is not None:
        from pounding_risk.figures import simulation_figure

        draw(simulation_figure(dataset), figure_file)
    move(dataset, moving)
    if strict and dataset.attrs["status"] != "complete":
        raise typer.Exit(RUN_FAILED)


app.command()(scan)


@app.command()
def compare(
    scene: Scene,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the dataset (.nc).", show_default=False)
    ] = None,
    overrides: Overrides = NONE,
    law: Annotated[
        list[str] | None, typer.Option(help="Contact model; repeat for several.", show_default="the grid's, or all")
    ] = None,
    baseline: Annotated[
        str | None, typer.Option(help="The law to set the others beside.", show_default="the interface's")
    ] = None,
    same: Annotated[
        str | None, typer.Option(help="Calibrate to equal: peak force, or penetration.", show_default="peak force")
    ] = None,
    speed: Annotated[
        str | None, typer.Option(help="Approach speed of the reference impact.", show_default="0.5 m/s")
    ] = None,
    relation: Annotated[
        str | None, typer.Option(help="Damping from e: exact, so that e is equal, or published.", show_default="exact")
    ] = None,
    new: New = False,
    figure: Figure = None,
    strict: Strict = False,
) -> None:
    """Run a scene under many contact models on equal terms."""
    out_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.compare import print_comparison
    from pounding_risk.results.summary import failures
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.compare import compare as run
    from pounding_risk.units import SPEED

    fast = None if speed is None else read_option("--speed", speed, SPEED)
    study = read_scene(scene, overrides)
    with Watch("compare") as watch:
        terms: dict[str, Any] = {"same": same, "speed": fast, "relation": relation}
        dataset = run(study, out_file, laws=law or (), baseline=baseline, **terms, new=new, progress=watch)
    print_comparison(dataset)
    if out_file is not None:
        typer.echo(f"written: {out_file}")
    if figure_file is not None:
        from pounding_risk.figures import agreement_figure, reference_figure

        draw(agreement_figure(dataset), figure_file)
        draw(reference_figure(dataset), figure_file.with_stem(f"{figure_file.stem}-impacts"))
    if strict and failures(dataset):
        raise typer.Exit(RUN_FAILED)


@app.command()
def accuracy(
    scene: Scene,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the dataset (.nc).", show_default=False)
    ] = None,
    overrides: Overrides = NONE,
    cases: Annotated[int, typer.Option(min=1, help="Cases of the grid, at most; thinned evenly.")] = 24,
    budget: Annotated[
        float, typer.Option(min=0.0, help="Seconds a setting may take; slower ones are left out.")
    ] = 20.0,
    scipy: Annotated[bool, typer.Option("--scipy/--no-scipy", help="Run SciPy's integrators too.")] = True,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What each digit of the answers costs in time, by method."""
    out_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.accuracy import print_accuracy
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.accuracy import accuracy as run

    study = read_scene(scene, overrides)
    with Watch("accuracy", "settings") as watch:
        dataset = run(study, out_file, cases=cases, budget=budget, scipy=scipy, new=new, progress=watch)
    print_accuracy(dataset)
    if out_file is not None:
        typer.echo(f"written: {out_file}")
    if figure_file is not None:
        from pounding_risk.figures import accuracy_figure

        draw(accuracy_figure(dataset), figure_file)


@app.command()
def effects(
    scene: Scene,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the dataset (.nc).", show_default=False)
    ] = None,
    overrides: Overrides = NONE,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What each effect changes in a scene, and what it costs."""
    out_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.effects import print_effects
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.effects import effects as run

    study = read_scene(scene, overrides)
    with Watch("effects", "scans") as watch:
        dataset = run(study, out_file, new=new, progress=watch)
    print_effects(dataset)
    if out_file is not None:
        typer.echo(f"written: {out_file}")
    if figure_file is not None:
        from pounding_risk.figures import effects_figure

        draw(effects_figure(dataset), figure_file)


@app.command()
def stability(
    rtol: Annotated[float, typer.Option(help="Tolerance of the solver, 1e-12 to 1e-2.")] = 1e-6,
    law: Annotated[
        list[str] | None, typer.Option(help="Contact model; repeat for several.", show_default="all")
    ] = None,
    case: Annotated[
        list[str] | None, typer.Option(help="Number of a case; repeat for several.", show_default="all")
    ] = None,
) -> None:
    """Run the hard cases and show what holds, and by how much."""
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.stability import print_stability
    from pounding_risk.studies.stability import stability as run

    with Watch("stability") as watch:
        rows = run(rtol, law, case, progress=watch)
    if not print_stability(rows):
        raise typer.Exit(RUN_FAILED)


for command in (
    models,
    modes,
    separations,
    assess,
    view,
    report,
    rerun,
    histories,
    convert,
    summary,
    draw_row,
    block,
    status,
):
    app.command()(command)
