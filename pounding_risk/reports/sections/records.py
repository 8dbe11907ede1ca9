"""Section on the records: what is known of each, the gap it needs, response spectra, and doubts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.figures.style import MEANING, blank, plain, styles, svg_text
from pounding_risk.motions.levels import FACTOR, PEAK
from pounding_risk.render.sheet import (
    DRAWN,
    KEPT,
    SMALL,
    Block,
    Cell,
    amount,
    figure,
    head,
    heading,
    listing,
    number,
    table,
)
from pounding_risk.reports.data import ReportData, at_amplitude
from pounding_risk.results.opened import Results
from pounding_risk.units import STANDARD_GRAVITY, rounded

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLE = "Records"
ORDER = 30
SHARING = 3  # records that share a doubt and are named


def write(data: ReportData) -> list[Block]:
    """The records with their facts and the gap that each needs, their spectra, and the doubts about them."""
    results = data.results
    spectra, periods = _spectra_felt(data), results["period"].values
    names = list(map(str, results["building"].values))
    periods_of_buildings = [
        (name, float(period))
        for name, period in zip(names, results["building_period"].values, strict=True)
        if np.isfinite(period)
    ]
    values = spectra.transpose("record", "period").values
    at = [
        f"{rounded(float(np.median(_at(values, periods, period))) / STANDARD_GRAVITY)} g at {period:.3g} s"
        for _, period in periods_of_buildings
    ]
    median = f" The median is {' and '.join(at)}." if at else ""
    blocks = [
        figure(
            "spectra",
            svg_text(draw_spectra(periods, values, periods_of_buildings)),
            f"Response spectra, damping 5 %, {_as_felt(data)}.",
            f"Spectral acceleration against period of {len(values)} records, with their median and the periods of the "
            f"buildings.{median}",
        ),
        _records_table(data),
    ]
    unused = data.facts("unused_keys", [])
    if unused:
        blocks += [
            heading("Keys of the scene without effect", "unused"),
            listing([f"{sentence}." for sentence in unused]),
        ]
    doubts = _doubts(data)
    if doubts:
        blocks += [heading("Doubts about the records", "doubts"), listing(doubts)]
    return blocks


def draw_spectra(periods: np.ndarray, spectra: np.ndarray, buildings: Sequence[tuple[str, float]]) -> Figure:
    """Each record's Sa [m/s²], (records, periods), median, 16th and 84th percentile, and the buildings' periods."""
    drawn, axes = blank(1, 1, DRAWN)
    axis, values, blue = axes[0, 0], spectra / STANDARD_GRAVITY, MEANING["motions"]
    is_ensemble = len(values) > 1
    words = f"{len(values)} records" if is_ensemble else "the record"
    look: dict[str, Any] = {"color": "#9a9a9a", "linewidth": 0.7} if is_ensemble else {"color": blue, "linewidth": 2.0}
    for index, spectrum in enumerate(values):
        axis.plot(periods, spectrum, label="" if index else words, **look)
    if is_ensemble:
        axis.plot(periods, np.median(values, axis=0), color=blue, linewidth=2.4, label="median")
    if len(values) > 2:
        for index, bound in enumerate(np.percentile(values, (16.0, 84.0), axis=0)):
            label = "" if index else "16th and 84th percentile"
            axis.plot(periods, bound, "--", color=blue, linewidth=1.3, label=label)
    for (name, period), (colour, dash) in zip(buildings, styles(len(buildings) + 1)[1:], strict=True):
        if periods[0] <= period <= periods[-1]:
            axis.axvline(period, color=colour, linestyle=dash, linewidth=1.6, label=f"{plain(name)}, {period:.3g} s")
    axis.set(xscale="log", yscale="log", xlabel="period [s]", ylabel="spectral acceleration [g]")
    axis.set_xlim(periods[0], periods[-1])
    for scale in (axis.xaxis, axis.yaxis):
        scale.set_major_formatter("{x:g}")
    axis.legend(fontsize=SMALL, loc="lower left")
    return drawn


def _is_felt_known(data: ReportData) -> bool:
    """Whether the dataset says what the buildings felt; those of older versions do not."""
    return "record_pga_felt" in data.results.coords


def _felt(data: ReportData, name: str) -> Any:
    """A coordinate of the records at the amplitude that is assessed."""
    return at_amplitude(data.results[name], data.assessment.interfaces[0].amplitude)


def _spectra_felt(data: ReportData) -> Any:
    """Sa [m/s²] of the records as the buildings felt them, or before the grid's amplitude where that is not known."""
    spectra = data.results["record_spectral_acceleration"]
    if not _is_felt_known(data):
        return spectra
    return spectra * _felt(data, "record_pga_felt") / data.results["record_pga"]


def _as_felt(data: ReportData) -> str:
    """The amplitude at which records are shown, in words."""
    if not _is_felt_known(data):
        return "of the records before the grid's amplitude"
    amplitude, amplitudes = data.assessment.interfaces[0].amplitude, Results(data.results).amplitudes
    measure = "a PGA" if amplitudes.measure == PEAK else amplitudes.measure.words
    at = "" if amplitude is None else f", scaled to {measure} of {amount(amplitude, amplitudes.measure.unit)['text']}"
    if amplitude is not None and amplitudes.measure.name == FACTOR:
        at = f", times {amplitudes.words(amplitude)}"
    return f"of the motions as the buildings felt them{at}"


def _at(values: Any, periods: Any, period: float) -> Any:
    return values[:, int(np.abs(np.log(periods / period)).argmin())]


def _records_table(data: ReportData) -> Block:
    results = data.results
    needed = results["peak_closing_free"]
    needed = needed.max("interface")
    widest_of = "; of a row the widest that any two neighbours need" if data.several else ""
    at = ""
    amplitudes = Results(results).amplitudes
    if amplitudes.axis in needed.dims:
        needed = at_amplitude(needed, data.assessment.interfaces[0].amplitude)
        measured = "" if amplitudes.measure == PEAK else f"{amplitudes.measure.words} of "
        at = f" at {measured}{amount(needed[amplitudes.axis], amplitudes.measure.unit)['text']}"
    polarities = list(map(str, results["polarity"].values))
    heads = [(words, "l") for words in ("record", "earthquake", "date")]
    heads += [("M", "r"), ("station", "l"), ("as found", "l"), ("dt [s]", "r")]
    heads += [("factor", "r")] if _is_felt_known(data) else []
    heads += [(head("PGA", "m/s2"), "r")]
    heads += [(f"gap needed, {words} [mm]", "r") for words in polarities]
    rows = []
    for name in map(str, results["record"].values):
        facts = data.records.get(name, {})
        event = [str(facts.get(key) or "–") for key in ("event", "date")]
        rows.append(
            [
                name,
                *event,
                number(facts.get("magnitude") or np.nan),
                str(facts.get("station") or "–"),
                str(facts.get("state") or "–"),
                number(facts.get("dt", np.nan)),
                *_amplitude_cells(data, name),
                *(number(needed.sel(record=name, polarity=polarity), "m") for polarity in polarities),
            ]
        )
    widest = np.argsort(-needed.max("polarity").values, kind="stable")[:KEPT]
    return table(
        f"Records. PGA is that {_as_felt(data)}{_factor_words(data)}; a smaller gap than the one needed leads "
        f"to contact{at}{widest_of}.",
        heads,
        rows,
        keep=sorted(map(int, widest)),
        note="the records that need the widest gaps",
    )


def _amplitude_cells(data: ReportData, record: str) -> list[Cell]:
    """Factor and PGA of a record; the PGA alone where the dataset does not say what the buildings felt."""
    if not _is_felt_known(data):
        return [number(data.results["record_pga"].sel(record=record), "m/s2")]
    factor, peak = (_felt(data, name).sel(record=record) for name in ("record_scale_factor", "record_pga_felt"))
    return [number(factor), number(peak, "m/s2")]


def _factor_words(data: ReportData) -> str:
    return "; factor is what the processed record was multiplied by" if _is_felt_known(data) else ""


def _doubts(data: ReportData) -> list[str]:
    """A sentence for each doubt, with the records that share it; then records that were left out."""
    sharing: dict[str, list[str]] = {}
    for record, flags in data.facts("flags", {}).items():
        for flag in flags:
            sharing.setdefault(flag, []).append(record)
    sentences = []
    for sentence, who in sharing.items():
        named = ", ".join(who) if len(who) <= SHARING else f"{who[0]} and {len(who) - 1} others"
        sentences.append(f"{named}: {sentence}.")
    return sentences + [f"Excluded: {sentence}." for sentence in data.facts("left_out", [])]
