"""The command line: each command reads its options, makes one call of the Python API, and prints what came of it.

Everything but typer is imported when a command runs, so that help and completion answer at once.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.collision import Impact
    from pounding_risk.quantities import Quantity

FIGURES = (".png", ".svg", ".pdf")
BAD_INPUT, INTERRUPTED = 2, 130
MOST_CONTACTS = 60  # rows of the table of contacts
PER_STIFFNESS = {"N/m": "k", "N/m^1.5": "β"}


class Commands(TyperGroup):
    """The commands; what a user can repair is told in sentences, without a traceback."""

    def invoke(self, ctx: Any) -> Any:
        """Run a command; bad input ends with status 2, Ctrl-C with 130."""
        try:
            return super().invoke(ctx)
        except PoundingError as error:
            typer.echo(f"pounding-risk: {error}", err=True)
            raise typer.Exit(BAD_INPUT) from None
        except KeyboardInterrupt:
            typer.echo("pounding-risk: stopped by Ctrl-C; no file was left half written", err=True)
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(cls=Commands, no_args_is_help=True, pretty_exceptions_enable=False, rich_markup_mode=None)
records_app = typer.Typer(help="List the strong-motion records that come with the project.")
app.add_typer(records_app, name="records")

Scene = Annotated[Path, typer.Argument(help="Scene file (TOML).", show_default=False)]
Overrides = Annotated[
    list[str],
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the scene, such as interface.gap='20 mm'."),
]
Figure = Annotated[Path | None, typer.Option(help="Write a figure (.png, .svg or .pdf).", show_default=False)]


def main() -> None:
    """Entry point of ``pounding-risk``."""
    app(prog_name="pounding-risk")


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
def demo(
    out: Annotated[Path, typer.Option(help="Folder for figures and datasets.")] = Path("pounding-demo"),
) -> None:
    """Run the pair of the 2011 paper under El Centro 1940: figures and a small dataset, in a minute."""
    check_folder(out)
    from pounding_risk.cli_output import print_pairs
    from pounding_risk.paper import demo as run

    start = perf_counter()
    written = run(out, typer.echo)
    print_pairs((f"{name}", str(path)) for name, path in written.items())
    typer.echo(f"Done in {perf_counter() - start:.1f} s.")


@app.command()
def validate(scene: Scene, set_: Overrides = []) -> None:  # noqa: B006  typer takes no other default
    """Check a scene and its records, count its cases, run nothing."""
    from pounding_risk.cli_output import engineering, print_pairs, print_table
    from pounding_risk.plan import validate as run

    plan = run(scene, set_)
    print_pairs(plan.summary())
    typer.echo()
    rows = [
        (
            record.name,
            record.event,
            record.state,
            f"{record.duration:.4g} s",
            f"{record.dt:.4g} s",
            engineering(record.pga, "m/s2"),
        )
        for record in plan.records
    ]
    print_table(("record", "event", "as found", "duration", "dt", "PGA"), rows, left=3)
    for record in plan.records:
        for flag in record.flags:
            typer.echo(f"note: {record.name}: {flag}")


@app.command()
def impact(
    law: Annotated[list[str], typer.Option(help="Contact model; repeat to compare.")] = ["jankowski"],  # noqa: B006
    stiffness: Annotated[
        list[str], typer.Option(help="β in N/m^1.5 or k in N/m; give one of each where both kinds of law are compared.")
    ] = ["2.75e9 N/m^1.5"],  # noqa: B006
    mass: Annotated[str, typer.Option(help="Mass of the striker.")] = "570 kg",
    other_mass: Annotated[str, typer.Option(help="Mass that is struck; inf for a fixed wall.")] = "inf",
    speed: Annotated[str, typer.Option(help="Speed of approach.")] = "0.5 m/s",
    restitution: Annotated[str, typer.Option(help="Coefficient e in (0, 1], or concrete.")] = "0.65",
    yield_force: Annotated[str, typer.Option(help="F_E, for laws with a cap; inf never yields.")] = "inf",
    figure: Figure = None,
) -> None:
    """Let two bodies collide once under each contact model: restitution achieved, force, penetration, energy."""
    target = target("--figure", figure, FIGURES)
    from pounding_risk.collision import impact as run
    from pounding_risk.collision import restitution_of
    from pounding_risk.quantities import MASS, SPEED, YIELD_FORCE

    striker = read("--mass", mass, MASS)
    struck = read("--other-mass", other_mass, MASS._replace(open_high=False))
    fast = read("--speed", speed, SPEED)
    strength = read("--yield-force", yield_force, YIELD_FORCE)
    rule = restitution_of(restitution)
    reduced = 1.0 / (1.0 / striker + 1.0 / struck)
    laws, notes = laws(law, stiffness, (fast, reduced, rule))
    found = [run(each, fast, striker, struck, restitution=rule, yield_force=strength) for each in laws]
    print_impacts(found, laws, 0.5 * reduced * fast**2)
    for note in notes:
        typer.echo(note)
    if target is not None:
        from pounding_risk.figures import impact_figure

        _draw(impact_figure(found), target)


@app.command()
def simulate(
    scene: Scene,
    set_: Overrides = [],  # noqa: B006
    record: Annotated[str | None, typer.Option(help="A record of the scene.", show_default="the first")] = None,
    polarity: Annotated[
        str | None, typer.Option(help="'as recorded' or 'reversed'.", show_default="the scene's first")
    ] = None,
    law: Annotated[str | None, typer.Option(help="Contact model.", show_default="the interface's")] = None,
    gap: Annotated[str | None, typer.Option(help="Gap.", show_default="the interface's")] = None,
    yield_force: Annotated[
        str | None, typer.Option(help="F_E; inf never yields.", show_default="the interface's")
    ] = None,
    pga: Annotated[str | None, typer.Option(help="Peak ground acceleration.", show_default="the scene's first")] = None,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Write the histories (.nc).", show_default=False)
    ] = None,
    figure: Figure = None,
) -> None:
    """Run one case of a scene in full: its outputs, its contacts, and if asked its histories and a figure."""
    dataset_file, figure_file = target("-o", out, (".nc",)), target("--figure", figure, FIGURES)
    from pounding_risk.quantities import GAP, PGA, YIELD_FORCE
    from pounding_risk.results import save
    from pounding_risk.scenario import read_scene
    from pounding_risk.history import simulate as run

    chosen: dict[str, Any] = {"record": record, "polarity": polarity, "law": law}
    for name, text, quantity in (("gap", gap, GAP), ("yield_force", yield_force, YIELD_FORCE), ("pga", pga, PGA)):
        chosen[name] = None if text is None else read(f"--{name.replace('_', '-')}", text, quantity)
    dataset = run(read_scene(scene, set_), **chosen)
    print_run(dataset)
    if dataset_file is not None:
        save(dataset, dataset_file)
        typer.echo(f"written: {dataset_file}")
    if figure_file is not None:
        from pounding_risk.figures import simulation_figure

        _draw(simulation_figure(dataset), figure_file)


@app.command()
def scan(
    scene: Scene,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="Results file (.nc).", show_default="the scene's name + .nc")
    ] = None,
    set_: Overrides = [],  # noqa: B006
    screening: Annotated[
        bool, typer.Option("--screening/--no-screening", help="Leave out runs whose answer is known exactly.")
    ] = True,
    workers: Annotated[int | None, typer.Option(min=1, help="Threads.", show_default="all processors")] = None,
    figure: Figure = None,
) -> None:
    """Run every case of a scene's grid and write one labelled dataset (netCDF)."""
    if out is None and Path(f"{scene.stem}.nc").exists():
        raise PoundingError(f"{scene.stem}.nc exists already; write -o {scene.stem}.nc to replace it, or another name")
    out_file, figure_file = (
        target("-o", out or Path(f"{scene.stem}.nc"), (".nc",)),
        target("--figure", figure, FIGURES),
    )
    from pounding_risk.cli_output import Watch
    from pounding_risk.ensemble import scan as run
    from pounding_risk.scenario import read_scene

    study = read_scene(scene, set_)
    start = perf_counter()
    with Watch("scan") as watch:
        dataset = run(study, out_file, screening=screening, workers=workers, progress=watch)
    print_scan(dataset, perf_counter() - start, out_file)
    if figure_file is not None:
        from pounding_risk.figures import scan_figure

        _draw(scan_figure(dataset), figure_file)


@records_app.callback(invoke_without_command=True)
def records(ctx: typer.Context) -> None:
    """List the strong-motion records that come with the project, or tell all about one."""
    if ctx.invoked_subcommand is None:
        list_records()


@records_app.command("list")
def list_records() -> None:
    """Every record of the catalogue."""
    from pounding_risk.catalogue import entries
    from pounding_risk.cli_output import engineering, print_table

    rows = [
        (
            entry.id,
            entry.event,
            entry.date,
            entry.station,
            entry.component,
            entry.state,
            engineering(entry.pga, "m/s2", 3),
            f"{entry.duration:.4g} s",
            f"{entry.dt:.4g} s",
        )
        for entry in entries()
    ]
    heads = ("record", "event", "date", "station", "component", "state", "PGA", "duration", "dt")
    print_table(heads, rows, left=6)


@records_app.command("info")
def record_info(id: Annotated[str, typer.Argument(metavar="ID", help="A record's id.")]) -> None:
    """All that the catalogue says about one record: origin, terms, checksum, where the file is."""
    from dataclasses import asdict

    from pounding_risk.catalogue import entry, path
    from pounding_risk.cli_output import engineering, print_pairs

    found = entry(id)
    try:
        place = str(path(id))
    except PoundingError as error:
        place = str(error)
    values = {key: value for key, value in asdict(found).items() if value not in ("", None)}
    del values["pga_g"]
    if found.sensitivity == 1.0:
        del values["sensitivity"]
    values |= {"dt": f"{found.dt:g} s", "duration": f"{found.duration:g} s", "PGA": engineering(found.pga, "m/s2")}
    if found.azimuth is not None:
        values["azimuth"] = f"{found.azimuth:g}° from north"
    print_pairs((key, " ".join(str(value).split())) for key, value in {**values, "file": place}.items())


def _draw(figure: Any, target: Path) -> None:
    try:
        figure.savefig(target)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    typer.echo(f"written: {target}")
