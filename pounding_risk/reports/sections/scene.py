"""What was asked: the buildings, what stands between them, the grid, what is assumed; and the records."""

from __future__ import annotations

from typing import Any

import numpy as np

from pounding_risk.figures.report import report_spectra, svg_text
from pounding_risk.reports.blocks import (
    KEPT,
    Block,
    Cell,
    amount,
    count,
    facts,
    figure,
    head,
    heading,
    listing,
    name_of,
    number,
    paragraph,
    rounded,
    table,
)
from pounding_risk.reports.material import Material
from pounding_risk.results.amplitudes import amplitude_words

SHARING = 3  # records that share a doubt and are named
ASSUMED = (
    "Each building is linear, with viscous damping, and moves as one mass; it stands on rigid ground.",
    "The buildings touch at one point, at the height of their masses.",
    "The ground acceleration is linear between the samples of a record.",
)
OF_A_ROW = (
    "Buildings move along the row only; floors are rigid, and each storey is a spring with viscous damping.",
    "Neighbours touch at the contact points that are listed with the row; a column moves with the floors at its ends, "
    "on the straight line between them.",
    ASSUMED[-1],
)


def scene(material: Material) -> list[Block]:
    """The pair, its interface, the grid of cases and what is assumed of them."""
    results = material.results
    sides = [("building", "l"), (head("mass", "kg"), "r"), ("period [s]", "r"), (head("damping", "%"), "r")]
    sides += [("storeys", "r"), ("height [m]", "r"), ("in the row", "l")] if material.is_row else []
    rows = []
    for name in map(str, results["building"].values):
        one = results.sel(building=name)
        values = [("building_mass", "kg"), ("building_period", "s"), ("building_damping", "%")]
        rows.append([name, *(number(one[each], unit) for each, unit in values), *_stature(material, one)])
    rigid = [
        str(row[0]) for row, period in zip(rows, results["building_period"].values, strict=True) if np.isnan(period)
    ]
    note = f"{' and '.join(rigid)}: rigid, moves with the ground." if rigid else ""
    pairs = enumerate(material.pairs)
    return [
        table("Buildings, left to right.", sides, rows),
        *([paragraph(note)] if note else []),
        *(facts(f"Between {pair.name.replace(' | ', ' and ')}.", _interface(material, place)) for place, pair in pairs),
        facts("The grid of cases.", _grid(material)),
        heading("Assumptions", "assumptions"),
        listing([*(OF_A_ROW if material.is_row else ASSUMED), *_assumed(material)]),
    ]


def _stature(material: Material, one: Any) -> list[Cell | str]:
    """Storeys, height and place of a building in a row; nothing of a pair's."""
    if not material.is_row:
        return []
    height = number(one["building_height"])
    return [count(one["building_storeys"]), height, str(one["building_position"].values)]


def _interface(material: Material, place: int) -> list[tuple[str, Cell | str]]:
    """The scene's interface, key by key as its file has it; the gap and the yield force in their units."""
    told: list[tuple[str, Cell | str]] = []
    tables = material.scene["interface"]
    for key, value in tables[min(place, len(tables) - 1)].items():
        if key == "gap":
            told.append(("gap", amount(_si(value), "m")))
        elif key in ("yield_force", "column_yield_force"):
            told.append(("yield force F_E" if key == "yield_force" else "of a column", _force(_si(value))))
        else:
            told.append((key.replace("_", " "), _said(value)))
    return told


def _si(value: Any) -> float:
    """The number of a quantity of a resolved scene, which is in SI."""
    return float(str(value).split()[0])


def _said(value: Any) -> str:
    """A value of a resolved scene in words; quantities are in SI there."""
    if isinstance(value, dict):
        return ", ".join(f"{key.replace('_', ' ')} {_said(each)}" for key, each in value.items()) or "no options"
    if isinstance(value, list):
        return ", ".join(map(_said, value))
    first, _, unit = str(value).partition(" ")
    try:
        return f"{rounded(float(first))} {unit}".strip()
    except ValueError:
        return str(value).replace("_", " ")


def _force(value: float) -> Cell:
    return {"text": "none: never yields", "raw": None} if np.isinf(value) else amount(value, "N")


def _grid(material: Material) -> list[tuple[str, Cell | str]]:
    results = material.results
    told: list[tuple[str, Cell | str]] = [("cases", count(results["status"].size))]
    told.append(("records", count(results.sizes["record"])))
    told.append(("polarity", ", ".join(map(str, results["polarity"].values))))
    if "pga" not in results.coords:
        told.append(("amplitude", amplitude_words(results)))
    whose = "gap of the interface that varies, or of the first" if "interface_gap" in results.variables else "gap"
    for name, words, unit in (("pga", "amplitude (PGA)", "m/s2"), ("gap", whose, "m"), ("yield_force", "F_E", "N")):
        if name in results.coords:
            told.append((words, _span(np.atleast_1d(results[name].values), unit)))
    told.append(("contact models", ", ".join(map(name_of, material.laws))))
    return told


def _span(values: Any, unit: str) -> Cell:
    finite = values[np.isfinite(values)]
    ends = [amount(each, unit) for each in dict.fromkeys((finite.min(), finite.max()))] if finite.size else []
    text = " to ".join(end["text"] for end in ends)
    if len(finite) > 1:
        text += f", {len(finite)} values"
    if len(finite) < len(values):
        text = f"{text}, and never yielding" if text else "never yields"
    return {"text": text, "parts": [end["raw"] for end in ends]}


def _assumed(material: Material) -> list[str]:
    """What else is taken for granted, as far as this scene's own keys tell."""
    told = []
    effects = material.scene.get("effects", {})
    if "wave_passage" not in effects:
        both = "All" if material.is_row else "Both"
        told.append(f"{both} buildings stand on the same motion at the same time.")
    if "permanent_set" not in effects and np.isfinite(material.results["yield_force"].values).any():
        told.append(
            "Yielding leaves no dent: laws with a yield force retrace their plateau, as published, unless the effect "
            "permanent_set is named."
        )
    held = int((material.results["restitution_held"] > 0).sum()) if "restitution_held" in material.results else 0
    if held:
        told.append(
            f"In {held} cases contacts are faster than the range of the restitution relation, which is held at its end."
        )
    return told


def records(material: Material) -> list[Block]:
    """The records with their facts and the gap that each needs, their spectra, and the doubts about them."""
    results = material.results
    spectra, periods = _spectra_felt(material), results["period"].values
    names = list(map(str, results["building"].values))
    known = [
        (name, float(period))
        for name, period in zip(names, results["building_period"].values, strict=True)
        if np.isfinite(period)
    ]
    values = spectra.transpose("record", "period").values
    at = [
        f"{rounded(float(np.median(_at(values, periods, period))) / 9.80665)} g at {period:.3g} s"
        for _, period in known
    ]
    median = f" The median is {' and '.join(at)}." if at else ""
    blocks = [
        figure(
            "spectra",
            svg_text(report_spectra(periods, values, known)),
            f"Response spectra, damping 5 %, {_as_felt(material)}.",
            f"Spectral acceleration against period of {len(values)} records, with their median and the periods of the "
            f"buildings.{median}",
        ),
        _records_table(material),
    ]
    unused = material.facts("unused_keys", [])
    if unused:
        blocks += [heading("Keys of the scene without effect", "unused"), listing([f"{each}." for each in unused])]
    doubts = _doubts(material)
    if doubts:
        blocks += [heading("Doubts about the records", "doubts"), listing(doubts)]
    return blocks


def _is_felt_known(material: Material) -> bool:
    """Whether the dataset says what the buildings felt; those of older versions do not."""
    return "record_pga_felt" in material.results.coords


def _felt(material: Material, name: str) -> Any:
    """A coordinate of the records at the amplitude that is assessed."""
    values = material.results[name]
    if "pga" not in values.dims:
        return values
    return values.sel(pga=material.assessment.interfaces[0].amplitude, method="nearest")


def _spectra_felt(material: Material) -> Any:
    """Sa [m/s²] of the records as the buildings felt them, or before the grid's amplitude where that is not known."""
    spectra = material.results["record_spectral_acceleration"]
    if not _is_felt_known(material):
        return spectra
    return spectra * _felt(material, "record_pga_felt") / material.results["record_pga"]


def _as_felt(material: Material) -> str:
    """At which amplitude records are shown, in words."""
    if not _is_felt_known(material):
        return "of the records before the grid's amplitude"
    amplitude = material.assessment.interfaces[0].amplitude
    at = "" if amplitude is None else f", scaled to a PGA of {amount(amplitude, 'm/s2')['text']}"
    return f"of the motions as the buildings felt them{at}"


def _at(values: Any, periods: Any, period: float) -> Any:
    return values[:, int(np.abs(np.log(periods / period)).argmin())]


def _records_table(material: Material) -> Block:
    results = material.results
    needed = results["peak_closing_free"]
    if "interface" in needed.dims:
        needed = needed.max("interface")
    widest_of = "; of a row the widest that any two neighbours need" if material.is_row else ""
    at = ""
    if "pga" in needed.dims:
        needed = needed.sel(pga=material.assessment.interfaces[0].amplitude, method="nearest")
        at = f" at {amount(needed['pga'], 'm/s2')['text']}"
    polarities = list(map(str, results["polarity"].values))
    heads = [(words, "l") for words in ("record", "earthquake", "date")]
    heads += [("M", "r"), ("station", "l"), ("as found", "l"), ("dt [s]", "r")]
    heads += [("factor", "r")] if _is_felt_known(material) else []
    heads += [(head("PGA", "m/s2"), "r")]
    heads += [(f"gap needed, {words} [mm]", "r") for words in polarities]
    rows = []
    for name in map(str, results["record"].values):
        one = material.records.get(name, {})
        said = [str(one.get(key) or "–") for key in ("event", "date")]
        rows.append(
            [
                name,
                *said,
                number(one.get("magnitude") or np.nan),
                str(one.get("station") or "–"),
                str(one.get("state") or "–"),
                number(one.get("dt", np.nan)),
                *_amplitude_cells(material, name),
                *(number(needed.sel(record=name, polarity=each), "m") for each in polarities),
            ]
        )
    widest = np.argsort(-needed.max("polarity").values, kind="stable")[:KEPT]
    return table(
        f"Records. PGA is that {_as_felt(material)}{_factor_words(material)}; a smaller gap than the one needed leads "
        f"to contact{at}{widest_of}.",
        heads,
        rows,
        keep=sorted(map(int, widest)),
        note="the records that need the widest gaps",
    )


def _amplitude_cells(material: Material, record: str) -> list[Cell]:
    """Factor and PGA of a record; the PGA alone where the dataset does not say what the buildings felt."""
    if not _is_felt_known(material):
        return [number(material.results["record_pga"].sel(record=record), "m/s2")]
    factor, peak = (_felt(material, name).sel(record=record) for name in ("record_scale_factor", "record_pga_felt"))
    return [number(factor), number(peak, "m/s2")]


def _factor_words(material: Material) -> str:
    return "; factor is what the processed record was multiplied by" if _is_felt_known(material) else ""


def _doubts(material: Material) -> list[str]:
    """A line for each doubt, with the records that share it; then what was left out."""
    sharing: dict[str, list[str]] = {}
    for record, sentences in material.facts("flags", {}).items():
        for sentence in sentences:
            sharing.setdefault(sentence, []).append(record)
    told = []
    for sentence, who in sharing.items():
        named = ", ".join(who) if len(who) <= SHARING else f"{who[0]} and {len(who) - 1} others"
        told.append(f"{named}: {sentence}.")
    return told + [f"Left out: {sentence}." for sentence in material.facts("left_out", [])]
