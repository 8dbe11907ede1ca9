"""Sheet of `compare`: contact models on equal terms, at one place or along axes of numbers of the scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import isnan, nan
from typing import Any

import xarray as xr

from pounding_risk.questions._declaration import Option
from pounding_risk.questions.notes import of_keys
from pounding_risk.render.sheet import (
    Block,
    Cell,
    Row,
    amount,
    between,
    facts,
    head,
    middle,
    milliseconds,
    noted,
    number,
    out_of,
    paragraph,
    table,
)
from pounding_risk.results.summary import failures
from pounding_risk.results.tolerance_check import findings
from pounding_risk.scene.scene import Scene
from pounding_risk.studies.compare_along import check_drawn, is_along, keys_along, places_along, widest_along
from pounding_risk.studies.compare_findings import (
    AT_SOME,
    FIRST_TWO,
    FLIPS,
    at_interface,
    comparable_laws,
    flip_share,
    furthest,
    index_of_interface,
    interface_names,
    most_frequent_flip,
    of_interface,
    percent,
    place_of_interface,
    which_interface,
    with_terms_of_its_own,
)

ORDER = 60
FUNCTION = "studies.compare"
OPTIONS = {"laws": Option("--law")}
FIGURES = {
    "": lambda comparison: "compare.agreement_along_figure" if is_along(comparison) else "compare.agreement_figure",
    "-impacts": lambda comparison: "" if is_along(comparison) else "compare.reference_figure",
}
# Whether the yield force acts in a law, of a row where each interface has a model of its own at some of them.
YIELDS: dict[int, list[str]] = {0: [], 1: ["yields at F_E"], AT_SOME: ["yields at F_E at some interfaces"]}
FLIPPED = ("displacement over 10 % off", "yielding or not", "required gap")  # `FLIPS` as heads of a table
ANOTHER = 'compare --interface "LEFT | RIGHT" shows another one'


def sheet(comparison: xr.Dataset, interface: str | None = None) -> list[Block]:
    """The finding, the terms of the comparison, ratios to the baseline, and the conclusions that change.

    Along axes one table with a row for each place.

    Parameters
    ----------
    interface : str, optional
        Whose tables, of a row, "left | right"; by default the one where the laws move the peak relative displacement
        most.
    """
    finding = paragraph(comparison.attrs["finding"])
    if is_along(comparison):
        return [finding, *_along(comparison, interface)]
    index = place_of_interface(comparison, interface)
    label, pair = which_interface(comparison, index), of_interface(comparison, index)
    row_blocks = [_interfaces(comparison), paragraph(f"The tables below are of {label}; {ANOTHER}.")] if label else []
    return [finding, _facts(comparison, pair), *row_blocks, _terms(pair), _ratios(pair), _disagreements(pair)]


def _along(comparison: xr.Dataset, interface: str | None) -> list[Block]:
    names = interface_names(comparison)
    index = widest_along(comparison) if interface is None else index_of_interface(names, interface)
    label = ""
    if len(names) > 1:
        rule = ", where the laws move the peak relative displacement most at any place" if interface is None else ""
        label = f"The table is of interface {names[index]} of {len(names)}{rule}; {ANOTHER}. "
    heads = [*keys_along(comparison), "cases with contact", *FIRST_TWO, *FLIPPED]
    places, counts = list(places_along(comparison)), comparison["impact_count"].isel(contact_model=0, interface=0)
    rows: list[Row] = []
    for place in places:
        pair = of_interface(place.part, index)
        laws = comparable_laws(pair)
        rows.append([*place.cells, *_extent(pair, counts.size // len(places), laws), *_most_flips(pair, laws)])
    caption = (
        f"Against {comparison.attrs['baseline']}: which law moves an output furthest (16 to 84 % of the ratios over "
        "the cases with contact), and in how many cases at most a conclusion differs."
    )
    return [
        _facts(comparison, at_interface(comparison, index), " at each place"),
        paragraph(f"{label}With --select of one value along each axis all tables of that place are shown."),
        table(caption, heads, rows),
    ]


def _facts(comparison: xr.Dataset, pair: xr.Dataset, where: str = "") -> Block:
    """What holds for the whole comparison: terms, checks, failures, excluded laws, approach speeds."""
    attrs = comparison.attrs
    equal_e = ", and the same e" if attrs.get("restitution_relation") == "exact" else ""
    speed = f" at {amount(attrs['speed'], 'm/s')['text']}" if "speed" in attrs else ""
    terms = f"the same {attrs['same']} as {attrs['reference_law']} in an impact{speed}{equal_e}"
    rows = [("equal terms", terms), *findings(comparison)]
    rows += [("failed", f"{count}: {name}") for name, count in failures(comparison).items()]
    rows += [("excluded", attrs["left_out"])] if attrs["left_out"] else []
    rows += [("unused", words) for words in of_keys(attrs)]
    rows += [("e", f"as published, not equal: {attrs['unequal_e']}")] if attrs["unequal_e"] else []
    fastest = pair["peak_approach_speed"].sel(contact_model=attrs["baseline"])
    fastest = fastest.where(fastest > 0.0)
    if int(fastest.notnull().sum()):
        low, median, high = (amount(fastest.quantile(share), "m/s", 2)["text"] for share in (0.16, 0.5, 0.84))
        spread = "" if low == high else f" (median; 16 to 84 %: {low} to {high})"
        rows.append(("approach", f"fastest touch of a case {median}{spread}; terms are equal at one speed only"))
    if not int(comparison["flips"].sel(conclusion="gap adequacy").sum()):
        is_pair = comparison.sizes["building"] == 2
        why = "the free motion decides whether there is contact at all" if is_pair else "at every interface of this row"
        rows.append(("required gap", f"the same under every law: {why}"))
    return facts(f"Comparison on equal terms{where}.", rows)


def _interfaces(comparison: xr.Dataset) -> Block:
    heads = ["interface", head("reduced mass", "kg"), "cases with contact"]
    names = comparable_laws(comparison)
    rows: list[Row] = []
    for index, interface in enumerate(interface_names(comparison)):
        pair = of_interface(comparison, index)
        cases = pair["impact_count"].isel(contact_model=0).size
        rows.append([interface, number(pair["reduced_mass"], "kg"), *_extent(pair, cases, names)])
    caption = "Interfaces: which law moves an output furthest (16 to 84 % of the ratios over the cases with contact)."
    return table(caption, [*heads, *FIRST_TWO], rows)


def _extent(pair: xr.Dataset, cases: int, laws: list[str]) -> Row:
    """In how many cases the baseline has contact, and which of the laws moves an output furthest."""
    touched = pair["judged"].sel(conclusion="displacement", contact_model=pair.attrs["baseline"])
    return [out_of(touched, cases), *(_range(*furthest(pair, name, laws)) if laws else "–" for name in FIRST_TWO)]


def _most_flips(pair: xr.Dataset, laws: list[str]) -> Iterator[str]:
    """How often at most each of `FLIPS` does, and under which law."""
    for conclusion in FLIPS:
        most, law = most_frequent_flip(flip_share(pair, conclusion, laws), laws, [""])
        yield "–" if isnan(most) else f"{percent(most)} ({law})" if most else "0 %"


def _terms(pair: xr.Dataset) -> Block:
    heads = ["law", "stiffness", "e requested", "e achieved", head("peak force", "N"), head("penetration", "m")]
    heads += ["duration [ms]", "note"]
    rows: list[Row] = []
    for name, has_own_terms in zip(pair["contact_model"].values, with_terms_of_its_own(pair), strict=True):
        law = pair.sel(contact_model=name)
        reference = law["reference_restitution_asked"]
        if bool(law["dissipates"]) and bool(reference.notnull()):
            note = []
        elif has_own_terms:
            note = ["e and force are its own: nothing can be made equal"]
        elif bool(law["dissipates"]):
            note = ["e is its own: no restitution can be given to it"]
        elif bool(reference.notnull()):
            note = ["elastic with e = 1"]
        else:
            note = ["elastic: cannot dissipate, no restitution can be given to it"]
        row: Row = [str(name), amount(law["stiffness"], str(law["stiffness_unit"].values) or "1")]
        row += [number(reference if law["dissipates"] else nan), number(law["reference_restitution"])]
        row += [number(law["reference_peak_force"], "N"), number(law["reference_peak_penetration"], "m", 3)]
        row.append(milliseconds(float(law["reference_duration"])))
        rows.append([*row, "; ".join([*note, *YIELDS[int(law["capped"])]])])
    return table("Terms: each law in the reference impact.", heads, rows)


def _ratios(pair: xr.Dataset) -> Block:
    outputs = [str(name) for name in pair["output"].values]
    rows: list[Row] = []
    for name in pair["contact_model"].values:
        spreads = (
            [float(pair[f"ratio_{end}"].sel(contact_model=name, output=output)) for end in ("low", "median", "high")]
            for output in outputs
        )
        rows.append([str(name), *(middle((low, median, high), "1") for low, median, high in spreads)])
    caption = f"Ratio to {pair.attrs['baseline']}: median (16 to 84 %) over the cases in which that has contact."
    # "peak" stands in all heads but of counts and impulses, and makes them longer than their numbers.
    heads = ["law", *(output.removeprefix("peak ") for output in outputs)]
    return table(caption, heads, rows)


def _disagreements(pair: xr.Dataset) -> Block:
    heads = ["law", "contact", "yielding", "displacement over 10 % off", "required gap"]
    heads += ["rank correlation: displacement", "force"]
    rows: list[Row] = []
    for name in pair["contact_model"].values:
        law = pair.sel(contact_model=name)
        counts = zip(law["flips"].values, law["judged"].values, strict=True)
        ranks = [number(law["rank_agreement"].sel(output=output)) for output in FIRST_TWO]
        rows.append([str(name), *(out_of(flips, judged) for flips, judged in counts), *ranks])
    caption = f"Cases in which a conclusion differs from that under {pair.attrs['baseline']}, and ranks of the motions."
    return table(caption, heads, rows)


def _range(law: str, low: float, high: float) -> Cell | str:
    """The 16 to 84 % range of a ratio, and the law that has it."""
    cell = between(low, high, "1", 3)
    return "–" if isnan(high) else noted(cell, f"({law})", law)


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for a figure that cannot be drawn, and for an interface that the scene has not."""
    study = options["study"]
    if isinstance(study, Scene):
        if "figure" in options:
            check_drawn(study.axes, "--figure")
        if "interface" in options:
            index_of_interface(study.interface_names, options["interface"])


def failed(comparison: xr.Dataset) -> bool:
    """Whether a run of the comparison failed, by which `--strict` ends the command."""
    return bool(failures(comparison))
