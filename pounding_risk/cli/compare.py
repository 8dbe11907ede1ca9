"""What `compare` prints: the equal terms, each law beside the baseline, the conclusions that flip, and the sentence."""

from __future__ import annotations

from math import isnan
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import NONE, RUN_FAILED, Figure, New, Overrides, Scene, Strict, read_option
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli._common.tables import engineering, print_pairs, print_table

ORDER = 60
HEADS = {
    "peak relative displacement": "displacement",
    "peak contact force": "force",
    "impact count": "count",
    "peak displacement": "displ.",
    "peak floor acceleration": "accel.",
}


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


def print_comparison(dataset: Any) -> None:
    """Three tables of one line a law, and the finding."""
    from pounding_risk.results.summary import failures
    from pounding_risk.results.tolerance_check import findings

    facts = dataset.attrs
    also = ", and the same e" if facts["restitution_relation"] == "exact" else ""
    terms = f"the same {facts['same']} as {facts['reference_law']} in an impact at {facts['speed']:g} m/s{also}"
    print(f"Equal terms: {terms}\n")
    _print_terms(dataset)
    print(f"\nRatio to {facts['baseline']}: median (16-84 %) over the cases with contact\n")
    _print_ratios(dataset)
    print(f"\nCases in which a law disagrees with {facts['baseline']}, and whether it ranks the motions alike\n")
    _print_flips(dataset)
    print()
    failed = [("failed", f"{count}: {name}") for name, count in failures(dataset).items()]
    without = [("left out", facts["left_out"])] if facts["left_out"] else []
    unequal = [("e", f"as published, not equal: {facts['unequal_e']}")] if facts["unequal_e"] else []
    told = [*findings(dataset), *failed, *without, *unequal, *_speeds(dataset), *_gaps(dataset)]
    print_pairs([*told, ("finding", facts["finding"])])


def _laws(dataset: Any) -> list[tuple[str, Any]]:
    return [(str(name), dataset.sel(contact_model=name)) for name in dataset["contact_model"].values]


def _print_terms(dataset: Any) -> None:
    from pounding_risk.scene.scene import known_law
    from pounding_risk.studies.compare_findings import with_terms_of_its_own

    heads = ("law", "stiffness", "e asked", "e achieved", "peak force", "penetration", "duration", "")
    rows = []
    own = dict(zip(dataset["contact_model"].values, with_terms_of_its_own(dataset), strict=True))
    for name, one in _laws(dataset):
        damped = int(one["dissipates"]) and known_law(name).needs_restitution
        kind = [] if damped else [_own_terms(one, own[name])]
        kind += ["yields at F_E"] if int(one["capped"]) else []
        unit = str(one["stiffness_unit"].values)
        rows.append(
            (
                name,
                _number(float(one["stiffness"]), ".4g", f" {unit}"),
                _number(float(one["reference_restitution_asked"]) if damped else float("nan"), ".3f"),
                _number(float(one["reference_restitution"]), ".3f"),
                engineering(float(one["reference_peak_force"]), "N"),
                engineering(float(one["reference_peak_penetration"]), "m", 3),
                _number(1e3 * float(one["reference_duration"]), ".3g", " ms"),
                "; ".join(kind),
            )
        )
    print_table(heads, rows, "lrrrrrrl")


def _own_terms(one: Any, force: bool) -> str:
    """Why a law has not the restitution asked for, or that it has one of 1."""
    from pounding_risk.scene.scene import known_law

    if force:
        return "e and force are its own: nothing can be made equal"
    if int(one["dissipates"]):
        return "e is its own: no restitution can be given to it"
    if known_law(str(one["contact_model"].values)).needs_restitution:
        return "elastic with e = 1"
    return "elastic: cannot dissipate, no restitution can be given to it"


def _print_ratios(dataset: Any) -> None:
    outputs = [str(name) for name in dataset["output"].values]
    rows = []
    for name, one in _laws(dataset):
        values = zip(*(one[f"ratio_{part}"].values for part in ("median", "low", "high")), strict=True)
        rows.append((name, *("–" if isnan(middle) else f"{middle:.2f} ({a:.2f}-{b:.2f})" for middle, a, b in values)))
    print_table(("law", *map(_head, outputs)), rows, "l" + "r" * len(outputs))


def _head(output: str) -> str:
    name, comma, building = output.partition(",")
    return HEADS.get(name, name) + comma + building


def _print_flips(dataset: Any) -> None:
    heads = ("law", "contact", "yielding", "displacement over 10 % off", "gap needed", "ranks: displacement", "force")
    rows = []
    for name, one in _laws(dataset):
        counts = zip(one["flips"].values, one["judged"].values, strict=True)
        told = [f"{count} of {judged}" if judged else "–" for count, judged in counts]
        ranks = (float(one["rank_agreement"].sel(output=output)) for output in list(HEADS)[:2])
        rows.append((name, *told, *(_number(rank, ".3f") for rank in ranks)))
    print_table(heads, rows, "l" + "r" * (len(heads) - 1))


def _speeds(dataset: Any) -> list[tuple[str, str]]:
    """How fast the touches are: the terms are equal at one speed only."""
    fastest = dataset["peak_approach_speed"].sel(contact_model=dataset.attrs["baseline"])
    fastest = fastest.where(fastest > 0.0)
    if not int(fastest.notnull().sum()):
        return []
    low, middle, high = (engineering(float(fastest.quantile(share)), "m/s", 2) for share in (0.16, 0.5, 0.84))
    words = f"fastest touch of a case {middle} (median; 16-84 %: {low} to {high}); terms are equal at one speed only"
    return [("approach", words)]


def _gaps(dataset: Any) -> list[tuple[str, str]]:
    """What the comparison says of the gap."""
    if int(dataset["flips"].sel(conclusion="gap adequacy").sum()):
        return []
    return [("gap needed", "the same under every law: the free motion decides whether there is contact at all")]


def _number(value: float, digits: str, unit: str = "") -> str:
    return "–" if isnan(value) else f"{value:{digits}}{unit}"
