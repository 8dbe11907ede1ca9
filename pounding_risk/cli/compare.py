"""The command `compare`: a scene under many contact models on equal terms."""

from __future__ import annotations

from math import isnan, nan
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import (
    NONE,
    RUN_FAILED,
    Dataset,
    Figure,
    New,
    Overrides,
    Scene,
    Select,
    Strict,
    chosen_scene,
    option,
    read_optional,
)
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import engineering, print_pairs, print_table

ORDER = 60
MOST_PLACES = 60  # rows of the table along axes
HEADS = {
    "peak relative displacement": "displacement",
    "peak contact force": "force",
    "impact count": "count",
    "peak displacement": "displ.",
    "peak floor acceleration": "accel.",
}


def compare(
    scene: Scene,
    out: Dataset = None,
    overrides: Overrides = NONE,
    law: Annotated[list[str] | None, option("Contact model; repeat for several.", "the grid's, or all")] = None,
    baseline: Annotated[str | None, option("The law to set the others beside.", "the interface's")] = None,
    same: Annotated[str | None, option("Calibrate to equal: peak force, or penetration.", "peak force")] = None,
    speed: Annotated[str | None, option("Approach speed of the reference impact.", "0.5 m/s")] = None,
    relation: Annotated[str | None, option("Damping from e: exact, so that e is equal, or published.", "exact")] = None,
    interface: Annotated[
        str | None, option("Of a row, whose tables: left | right.", "where the laws differ most")
    ] = None,
    select: Select = NONE,
    new: New = False,
    figure: Figure = None,
    strict: Strict = False,
) -> None:
    """Run a scene under many contact models on equal terms."""
    from pounding_risk.results.summary import failures
    from pounding_risk.studies.compare import compare as run
    from pounding_risk.studies.compare_along import check_drawn, is_along
    from pounding_risk.studies.compare_findings import index_of_interface
    from pounding_risk.units import SPEED

    terms: dict[str, Any] = {"same": same, "speed": read_optional("--speed", speed, SPEED), "relation": relation}
    study = chosen_scene(scene, overrides, select)
    if interface is not None:
        index_of_interface(study.interface_names, interface)
    if figure is not None:
        check_drawn(study.axes, "--figure")
    with ProgressDisplay("compare") as progress:
        dataset = run(study, out, laws=law or (), baseline=baseline, **terms, new=new, progress=progress)
    if is_along(dataset):
        print_along(dataset, interface)
        announce(out)
        draw(figure, "compare_along.agreement_along_figure", dataset, interface=interface)
    else:
        print_comparison(dataset, interface)
        announce(out)
        draw(figure, "compare.agreement_figure", dataset, interface=interface)
        impacts = figure and figure.with_stem(f"{figure.stem}-impacts")
        draw(impacts, "compare.reference_figure", dataset, interface=interface)
    if strict and failures(dataset):
        raise typer.Exit(RUN_FAILED)


def print_along(comparison: Any, interface: str | None = None) -> None:
    """Print one line a place along the axes, of a row those of one interface, and how the finding changes."""
    from pounding_risk.studies.compare_along import FLIPPED, keys_along, rows_along, widest_along
    from pounding_risk.studies.compare_findings import at_interface, index_of_interface, interface_names

    names = interface_names(comparison)
    index = widest_along(comparison) if interface is None else index_of_interface(names, interface)
    print(f"Equal terms at each place: {_terms_words(comparison)}\n")
    if len(names) > 1:
        rule = ", where the laws move the peak relative displacement most at any place" if interface is None else ""
        print(f'Interface {names[index]} of {len(names)}{rule}; another one: --interface "LEFT | RIGHT"\n')
    print(
        f"Against {comparison.attrs['baseline']}: which law moves an output furthest (16-84 % of the ratios over the "
        "cases with contact), and in how many cases at most a conclusion flips\n"
    )
    rows = list(rows_along(comparison, index))
    heads = (*keys_along(comparison), "cases with contact", "displacement", "force", *FLIPPED)
    cells = [
        (*row.cells, f"{row.touched} of {row.cases}", *(_range_words(*one) for one in row.furthest), *row.flips)
        for row in rows[:MOST_PLACES]
    ]
    print_table(heads, cells, "l" * len(keys_along(comparison)) + "r" + "l" * (2 + len(FLIPPED)))
    if len(rows) > MOST_PLACES:
        print(f"and {len(rows) - MOST_PLACES} more; -o writes them all, --select chooses some")
    print("--select of one value along each axis gives the whole comparison\n")
    _print_facts(comparison, at_interface(comparison, index))


def print_comparison(comparison: Any, interface: str | None = None) -> None:
    """Print three tables of one line a law, of a row those of one interface and one of all, and the finding."""
    from pounding_risk.studies.compare_findings import of_interface, place_of_interface, which_interface

    index = place_of_interface(comparison, interface)
    which, dataset = which_interface(comparison, index), of_interface(comparison, index)
    facts = dataset.attrs
    print(f"Equal terms: {_terms_words(dataset)}\n")
    if which:
        _print_interfaces(comparison)
        print(f'\n{which[0].upper()}{which[1:]}; another one: --interface "LEFT | RIGHT"\n')
    _print_terms(dataset)
    print(f"\nRatio to {facts['baseline']}: median (16-84 %) over the cases with contact\n")
    _print_ratios(dataset)
    print(f"\nCases in which a law disagrees with {facts['baseline']}, and whether it ranks the motions alike\n")
    _print_disagreements(dataset)
    print()
    _print_facts(comparison, dataset)


def _terms_words(dataset: Any) -> str:
    """What the laws have in common in the reference impact, and at which speed, where that is one."""
    facts = dataset.attrs
    also = ", and the same e" if facts.get("restitution_relation") == "exact" else ""
    speed = f" at {facts['speed']:g} m/s" if "speed" in facts else ""
    return f"the same {facts['same']} as {facts['reference_law']} in an impact{speed}{also}"


def _print_facts(comparison: Any, of_interface: Any) -> None:
    """Print what holds for the whole comparison: checks, failures, what is left out, approach speeds, the finding."""
    from pounding_risk.results.summary import failures
    from pounding_risk.results.tolerance_check import findings

    facts = comparison.attrs
    failed = [("failed", f"{count}: {name}") for name, count in failures(comparison).items()]
    without = [("left out", facts["left_out"])] if facts["left_out"] else []
    unequal = [("e", f"as published, not equal: {facts['unequal_e']}")] if facts["unequal_e"] else []
    pairs = [*findings(comparison), *failed, *without, *unequal, *_approach_speeds(of_interface)]
    print_pairs([*pairs, *_gap_adequacy(comparison), ("finding", facts["finding"])])


def _print_interfaces(dataset: Any) -> None:
    """Print one line an interface of a row: cases with contact, and the laws that move displacement and force most."""
    from pounding_risk.studies.compare_findings import furthest, interface_names, of_interface, peers
    from pounding_risk.units import say_in

    names, heads = peers(dataset), list(HEADS)[:2]
    rows = []
    for index, interface in enumerate(interface_names(dataset)):
        part = of_interface(dataset, index)
        touched = int(part["judged"].sel(conclusion="displacement", contact_model=part.attrs["baseline"]))
        mass = say_in(float(part["reduced_mass"]), "t")
        cells = [_range_words(*furthest(part, output, names)) if names else "–" for output in heads]
        rows.append(
            (interface, mass, f"{touched} of {part['impact_count'].size // part.sizes['contact_model']}", *cells)
        )
    print_table(("interface", "reduced mass", "cases with contact", *(HEADS[head] for head in heads)), rows, "lrrll")


def _range_words(law: str, low: float, high: float) -> str:
    """The 16-84 % range of a ratio and the law that has it."""
    return "–" if isnan(high) else f"{low:.2f}-{high:.2f} ({law})"


def _laws(dataset: Any) -> list[tuple[str, Any]]:
    """Name of each contact model and its part of the dataset."""
    return [(str(name), dataset.sel(contact_model=name)) for name in dataset["contact_model"].values]


def _print_terms(dataset: Any) -> None:
    """Print the stiffness of each law and what it does in the reference impact."""
    from pounding_risk.scene.interfaces import known_law
    from pounding_risk.studies.compare_findings import with_terms_of_its_own

    heads = ("law", "stiffness", "e asked", "e achieved", "peak force", "penetration", "duration", "")
    rows = []
    for (name, law), has_own_terms in zip(_laws(dataset), with_terms_of_its_own(dataset), strict=True):
        takes_restitution = int(law["dissipates"]) and known_law(_model_of(law)).needs_restitution
        notes = [] if takes_restitution else [_own_terms(law, has_own_terms)]
        notes += ["yields at F_E"] if known_law(_model_of(law)).capped else []
        rows.append(
            (
                name,
                _number(float(law["stiffness"]), ".4g", f" {law['stiffness_unit'].values}"),
                _number(float(law["reference_restitution_asked"]) if takes_restitution else nan, ".3f"),
                _number(float(law["reference_restitution"]), ".3f"),
                engineering(float(law["reference_peak_force"]), "N"),
                engineering(float(law["reference_peak_penetration"]), "m", 3),
                _number(1e3 * float(law["reference_duration"]), ".3g", " ms"),
                "; ".join(notes),
            )
        )
    print_table(heads, rows, "lrrrrrrl")


def _model_of(law: Any) -> str:
    """Name of the contact model; of the interface's own where the label stands for those of all interfaces."""
    from pounding_risk.scene.scene import OF_EACH_INTERFACE

    name = str(law["contact_model"].values)
    return str(law["interface_contact_model"].values) if name == OF_EACH_INTERFACE else name


def _own_terms(law: Any, has_own_terms: bool) -> str:
    """Why a law does not have the restitution that is asked for."""
    from pounding_risk.scene.interfaces import known_law

    if has_own_terms:
        return "e and force are its own: nothing can be made equal"
    if int(law["dissipates"]):
        return "e is its own: no restitution can be given to it"
    if known_law(_model_of(law)).needs_restitution:
        return "elastic with e = 1"
    return "elastic: cannot dissipate, no restitution can be given to it"


def _print_ratios(dataset: Any) -> None:
    """Print the ratio of each output to that under the baseline."""
    outputs = [str(name) for name in dataset["output"].values]
    rows = []
    for name, law in _laws(dataset):
        ratios = zip(*(law[f"ratio_{part}"].values for part in ("median", "low", "high")), strict=True)
        cells = ("–" if isnan(middle) else f"{middle:.2f} ({low:.2f}-{high:.2f})" for middle, low, high in ratios)
        rows.append((name, *cells))
    print_table(("law", *map(_head, outputs)), rows, "l" + "r" * len(outputs))


def _head(output: str) -> str:
    """The short name of an output; that of a building keeps its name."""
    name, comma, building = output.partition(",")
    return HEADS.get(name, name) + comma + building


def _print_disagreements(dataset: Any) -> None:
    """Print in how many cases each law changes a conclusion, and the agreement of ranks."""
    heads = ("law", "contact", "yielding", "displacement over 10 % off", "gap needed", "ranks: displacement", "force")
    rows = []
    for name, law in _laws(dataset):
        counts = zip(law["flips"].values, law["judged"].values, strict=True)
        cells = [f"{count} of {judged}" if judged else "–" for count, judged in counts]
        ranks = (float(law["rank_agreement"].sel(output=output)) for output in list(HEADS)[:2])
        rows.append((name, *cells, *(_number(rank, ".3f") for rank in ranks)))
    print_table(heads, rows, "l" + "r" * (len(heads) - 1))


def _approach_speeds(dataset: Any) -> list[tuple[str, str]]:
    """The approach speeds of the fastest contact of each case; the terms are equal at one speed only."""
    fastest = dataset["peak_approach_speed"].sel(contact_model=dataset.attrs["baseline"])
    fastest = fastest.where(fastest > 0.0)
    if not int(fastest.notnull().sum()):
        return []
    low, middle, high = (engineering(float(fastest.quantile(share)), "m/s", 2) for share in (0.16, 0.5, 0.84))
    spread = "" if low == high else f" (median; 16-84 %: {low} to {high})"
    return [("approach", f"fastest touch of a case {middle}{spread}; terms are equal at one speed only")]


def _gap_adequacy(dataset: Any) -> list[tuple[str, str]]:
    """A sentence where no law changes whether a gap suffices."""
    if int(dataset["flips"].sel(conclusion="gap adequacy").sum()):
        return []
    alone = dataset.sizes["building"] == 2
    why = "the free motion decides whether there is contact at all" if alone else "at every interface of this row"
    return [("gap needed", f"the same under every law: {why}")]


def _number(value: float, digits: str, unit: str = "") -> str:
    return "–" if isnan(value) else f"{value:{digits}}{unit}"
