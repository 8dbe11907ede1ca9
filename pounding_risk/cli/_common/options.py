"""Arguments and options that several commands take, and the reading of values with units."""

from __future__ import annotations

from collections.abc import Callable
from inspect import Parameter, Signature
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, writable
from pounding_risk.errors import PoundingError
from pounding_risk.units import Quantity, QuantityError, parse

BAD_INPUT, RUN_FAILED, INTERRUPTED = 2, 3, 130  # exit statuses
NONE: list[Any] = []  # default of an option that may be repeated
Fields = dict[str, tuple[Any, Any]]  # annotation, as typer takes it, and default of each argument and option, by name
REQUIRED = Parameter.empty


def with_options(run: Callable[[dict[str, Any]], None], fields: Fields, help: str) -> Callable[..., None]:
    """The function of a command with these arguments and options, from whose signature typer reads them.

    It hands their values, by name, to ``run``.
    """

    def command(**options: Any) -> None:
        run(options)

    parameters = [
        Parameter(name, Parameter.KEYWORD_ONLY, default=default, annotation=annotation)
        for name, (annotation, default) in fields.items()
    ]
    command.__signature__ = Signature(parameters)  # type: ignore[attr-defined] # typer reads it
    command.__annotations__ = {name: annotation for name, (annotation, _) in fields.items()}
    command.__doc__ = help
    return command


def argument(metavar: str, help: str) -> Any:
    """Declare a positional argument without a default, shown in the help as ``metavar``."""
    return typer.Argument(metavar=metavar, help=help, show_default=False)


def option(help: str, absence: str | None = None, *names: str, **settings: Any) -> Any:
    """An option. The help shows what holds in its ``absence``, by default its value; the rest is for `typer.Option`."""
    return typer.Option(*names, help=help, show_default=absence or True, **settings)


def file_option(description: str, suffixes: tuple[str, ...], *names: str, absence: str | None = None) -> Any:
    """An option that takes a file to write. The file is checked before the command runs; the help lists the suffixes.

    An error names the option by the shortest of its ``names``; the help shows what holds in its ``absence``.
    """

    def check(parameter: typer.CallbackParam, path: Path | None) -> Path | None:
        return writable(min(parameter.opts, key=len), path, suffixes)

    *first_suffixes, last = suffixes
    kinds = f"{', '.join(first_suffixes)} or {last}" if first_suffixes else last
    return typer.Option(*names, help=f"{description} ({kinds}).", show_default=absence or True, callback=check)


def out_option(description: str, *suffixes: str, absence: str | None = None) -> Any:
    """The option ``--out``, see `file_option`."""
    return file_option(description, suffixes, "--out", "-o", absence=absence)


Scene = Annotated[Path, argument("SCENE", "Scene file (TOML).")]
Results = Annotated[Path, argument("RESULTS", "Dataset of a scan (.nc or .zarr).")]
OptionalResults = Annotated[
    Path | None, typer.Argument(metavar="[RESULTS]", help="Dataset of a scan (.nc or .zarr).", show_default=False)
]
Overrides = Annotated[
    list[str],
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the scene, such as interface.gap='20 mm'."),
]
Figure = Annotated[Path | None, file_option("Write a figure", FIGURES)]
Strict = Annotated[bool, typer.Option("--strict", help="End with status 3 where a run failed.")]
New = Annotated[bool, typer.Option("--new", help="Replace a file that holds other results.")]
Workers = Annotated[int | None, option("Threads.", "one a processor", min=1)]
Hazard = Annotated[
    Path | None,
    option(
        "Hazard (.csv): PGA, PGV or Sa with unit, and annual rate, return period or probability in years; or spectra; "
        "or an export of OpenQuake."
    ),
]
Gmfs = Annotated[
    Path | None, option("Ground-motion fields of OpenQuake (.csv), for probabilities in a scenario or an event set.")
]
Site = Annotated[
    str | None,
    option('Site of an export of OpenQuake: "23.73, 37.98", "23.73, 37.98 within 20 km", or an id.', "its only one"),
]
Select = Annotated[
    list[str],
    typer.Option("--select", metavar="AXIS=VALUE", help="One value of an axis, such as building.frame.period='0.5 s'."),
]


def chosen_scene(scene: Path, overrides: list[str], select: list[str]) -> Any:
    """The scene of a file with its overrides, at the values of ``select`` along its axes, which are then none."""
    from pounding_risk.results.scene_axes import overrides_of
    from pounding_risk.scene.reader import read_scene

    study = read_scene(scene, overrides)
    return read_scene(scene, [*overrides, *overrides_of(study.axes, select, str(scene))]) if select else study


def chosen_results(results: Path, select: list[str]) -> Any:
    """The file itself where nothing is selected, or its dataset at the values of ``select``, stated in the title."""
    if not select:
        return results
    from pounding_risk.results.scene_axes import at_one_place, open_axes, selected, title_at

    dataset = selected(_checked(results), select, str(results))
    return title_at(dataset if open_axes(dataset) else at_one_place(dataset, str(results)), select)


def opened_results(results: Path, select: list[str]) -> Any:
    """As `chosen_results`; the dataset of a file whose cases lie along axes of numbers of the scene."""
    from pounding_risk.results.files import stream_results
    from pounding_risk.results.scene_axes import open_axes

    chosen = chosen_results(results, select)
    if not isinstance(chosen, Path):
        return chosen
    with stream_results(chosen) as head:
        has_axes = bool(open_axes(head))
    return _checked(chosen) if has_axes else chosen


def _checked(results: Path) -> Any:
    """The dataset of a file, checked here if it is of a scan, as the dataset itself does not know its file's name."""
    from pounding_risk.results.check import check_scan, kind_of
    from pounding_risk.results.files import open_results

    dataset = open_results(results)
    if kind_of(dataset) == "scan":
        check_scan(dataset, str(results))
    return dataset


def read_option(option: str, text: str, quantity: Quantity) -> float:
    """The SI value of an option's text; raises PoundingError that names the option."""
    try:
        return parse(text, quantity)
    except QuantityError as error:
        raise PoundingError(f"{option}: {error}") from None


def read_optional(option: str, text: str | None, quantity: Quantity) -> float | None:
    """The SI value of an option's text, or None where the option is not given; raises as `read_option`."""
    return None if text is None else read_option(option, text, quantity)
