"""Section on the records: what is known of each, the gap it needs, response spectra, and doubts."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from pounding_risk.figures.motions import draw_spectra
from pounding_risk.figures.style import panel
from pounding_risk.motions.levels import FACTOR, PEAK
from pounding_risk.motions.record import AFTERSHOCK
from pounding_risk.questions.notes import of_records
from pounding_risk.render.sheet import KEPT, MISSING, Block, Cell, amount, figure, head, heading, listing, number, table
from pounding_risk.reports.data import ReportData, at_amplitude
from pounding_risk.results.attributes import gaps_needed
from pounding_risk.results.opened import Results
from pounding_risk.units import STANDARD_GRAVITY, rounded

TITLE = "Records"
ORDER = 30


def write(data: ReportData) -> list[Block]:
    """The records with their facts and the gap that each needs, their spectra, and the doubts about them."""
    results = data.results
    is_felt = "record_pga_felt" in results.coords  # what the buildings felt; datasets of older versions lack it
    as_felt = _felt_words(data) if is_felt else "of the records before the grid's amplitude"
    spectra = results["record_spectral_acceleration"]
    if is_felt:
        spectra = spectra * _at_assessed(data, "record_pga_felt") / results["record_pga"]
    values, periods = spectra.transpose("record", "period").values, results["period"].values
    pairs = zip(results["building"].values, results["building_period"].values, strict=True)
    building_periods = [(str(name), float(period)) for name, period in pairs if np.isfinite(period)]
    isolated = ((f"{name} as isolators yield", period) for name, period in data.isolated_periods.items())
    building_periods += [(words, period) for words, period in isolated if period <= periods[-1]]
    medians = []
    for _, period in building_periods:
        nearest = values[:, int(np.abs(np.log(periods / period)).argmin())]
        medians.append(f"{rounded(float(np.median(nearest)) / STANDARD_GRAVITY)} g at {period:.3g} s")
    alt = f"Spectral acceleration against period of {len(values)} records, with their median and the periods of the "
    alt += f"buildings. The median is {' and '.join(medians)}." if medians else "buildings."
    drawing = partial(panel, draw_spectra, periods, values, (16.0, 84.0), building_periods)
    blocks = [
        figure("spectra", drawing, f"Response spectra, damping 5 %, {as_felt}.", alt),
        _records_table(data, is_felt, as_felt),
    ]
    unused = data.facts("unused_keys", [])
    doubts = [f"{sentence}." for sentence in of_records(data.facts("flags", {}))]
    doubts += [f"Excluded: {sentence}." for sentence in data.facts("left_out", [])]
    if unused:
        unused_keys = listing([f"{sentence}." for sentence in unused])
        blocks += [heading("Keys of the scene without effect", "unused"), unused_keys]
    return blocks + ([heading("Doubts about the records", "doubts"), listing(doubts)] if doubts else [])


def _at_assessed(data: ReportData, name: str) -> Any:
    """A coordinate of the records at the amplitude that is assessed."""
    return at_amplitude(data.results[name], data.assessment.interfaces[0].amplitude)


def _felt_words(data: ReportData) -> str:
    """The amplitude at which records are shown, as the buildings felt them."""
    amplitude, amplitudes = data.assessment.interfaces[0].amplitude, Results(data.results).amplitudes
    at = ""
    if amplitude is not None and amplitudes.measure.name == FACTOR:
        at = f", times {amplitudes.words(amplitude)}"
    elif amplitude is not None:
        measure = "a PGA" if amplitudes.measure == PEAK else amplitudes.measure.words
        at = f", scaled to {measure} of {amount(amplitude, amplitudes.measure.unit)['text']}"
    return f"of the motions as the buildings felt them{at}"


def _records_table(data: ReportData, is_felt: bool, as_felt: str) -> Block:
    results, amplitudes = data.results, Results(data.results).amplitudes
    gaps = gaps_needed(results).max("interface")
    amplitude = ""
    if amplitudes.axis in gaps.dims:
        gaps = at_amplitude(gaps, data.assessment.interfaces[0].amplitude)
        measured = "" if amplitudes.measure == PEAK else f"{amplitudes.measure.words} of "
        amplitude = f" at {measured}{amount(gaps[amplitudes.axis], amplitudes.measure.unit)['text']}"
    polarities = list(map(str, results["polarity"].values))
    records = [data.records.get(str(name), {}) for name in results["record"].values]
    is_sequence = any(facts.get(AFTERSHOCK) for facts in records)
    heads = ["record", *["aftershock"] * is_sequence, "earthquake", "date", "M", "station", "as found", "dt [s]"]
    heads += ["factor"] if is_felt else []
    heads += [head("PGA", "m/s2"), *(f"gap needed, {words} [mm]" for words in polarities)]
    rows: list[list[Cell | str]] = []
    for name, facts in zip(map(str, results["record"].values), records, strict=True):
        event, date, station, state = (str(facts.get(key) or MISSING) for key in ("event", "date", "station", "state"))
        behind = [str(facts.get(AFTERSHOCK, {}).get("name", MISSING))] * is_sequence
        row: list[Cell | str] = [name, *behind, event, date, number(facts.get("magnitude") or np.nan), station, state]
        row.append(number(facts.get("dt", np.nan)))
        if is_felt:
            row.append(number(_at_assessed(data, "record_scale_factor").sel(record=name)))
        peak = _at_assessed(data, "record_pga_felt") if is_felt else results["record_pga"]
        row.append(number(peak.sel(record=name), "m/s2"))
        rows.append([*row, *(number(gaps.sel(record=name, polarity=polarity), "m") for polarity in polarities)])
    factor = "; factor is what the processed record was multiplied by" * is_felt
    widest_of = "; of a row the widest that any two neighbours need" * data.several
    caption = f"Records. PGA is that {as_felt}{factor}; a smaller gap than the one needed leads to contact"
    first = "; earthquake, date, M, station and as found are those of the record before its aftershock" * is_sequence
    lost_note = "; – without a finite response, for which no gap is wide enough" * bool(gaps.isnull().any())
    caption += f"{amplitude}{widest_of}{first}{lost_note}."
    keep = sorted(map(int, np.argsort(-gaps.fillna(np.inf).max("polarity").values, kind="stable")[:KEPT]))
    return table(caption, heads, rows, keep=keep, note="the records that need the widest gaps")
