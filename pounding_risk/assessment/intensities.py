"""Intensities of the motions of a dataset of `scan`, and the hazard and ground-motion fields that go with them."""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.assessment.demands import by_amplitude
from pounding_risk.assessment.gmfs import Fields, read_fields
from pounding_risk.assessment.hazard import Hazard, HazardSpectrum
from pounding_risk.assessment.hazard_table import read_hazard
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import FACTOR, LEVEL_AXIS, PGA_AXIS, Measure, read_measure, sa_at
from pounding_risk.motions.scaling import mean_periods
from pounding_risk.results.amplitudes import intensity_words
from pounding_risk.results.attributes import isolated_buildings, yielding_buildings
from pounding_risk.results.opened import Results

Array = NDArray[np.float64]

# Keys of a building of one elastic mass, and effects, with which the record alone moves it on its ground: a delay and
# a velocity of the ground change nothing there. Keys that are not listed may.
OF_OSCILLATORS = {"name", "mass", "period", "stiffness", "damping", "damping_rule", "height", "floor_depth"} | {
    *("floor_length", "wave_speed", "column_strength", "ground_delay", "ground_velocity", "storeys", "floor_masses"),
    *("storey_stiffnesses", "storey_heights", "storey_strengths"),
}
WITHOUT_EFFECT = {"permanent_set", "unloading_stiffness", "strain_rate", "wave_passage", "inelastic_storeys"}
NEAR = 0.05  # of a building's period, by which that of a hazard curve may differ: Sa hardly does
PERIOD_WORDS = {
    "sa(longer)": ", at the longest period of the buildings",
    "sa(shorter)": ", at the shortest period of the buildings",
    "sa(mean)": ", at the geometric mean of the buildings' periods",
}


class Shaking(NamedTuple):
    """What fragilities are against: the intensity, its hazard curve and how that was read, and ground-motion fields."""

    intensity: str
    hazard: Hazard | None = None
    reading: str = ""
    fields: Fields | None = None

    def events(self, results: Results) -> Array | None:
        """Intensities of the events of the fields [SI], of a dataset in which buildings have periods; None without."""
        return None if self.fields is None else self.fields.at(spectral_intensity(results, self.intensity))


def shaking_of(
    results: Results,
    hazard: Hazard | HazardSpectrum | str | Path | None,
    gmfs: Fields | str | Path | None,
    requested: str | None,
) -> Shaking:
    """The intensity of fragilities, as requested or as usual, with its hazard curve and fields, as `assess` takes them.

    Raises PoundingError for an intensity that the dataset or the hazard has not, and as `read_hazard` and
    `read_fields`.
    """
    fields = read_fields(gmfs) if isinstance(gmfs, str | Path) else gmfs
    hazard_data = read_hazard(hazard) if isinstance(hazard, str | Path) else hazard
    usual = results.usual_intensity
    if fields is not None and requested is None and hazard_data is None:
        requested = usual
        if not fields.has(spectral_intensity(results, usual)):
            sa_longer = resolved_intensity(results, "sa(longer)")
            requested = next((name for name in (sa_longer, "pga") if fields.has(name)), usual)
    if isinstance(hazard_data, HazardSpectrum):
        word = "" if usual.startswith("sa(") else "sa(longer)"
        intensity = resolved_intensity(results, requested or word or usual)
        curve = hazard_data.at(spectral_intensity(results, intensity))
        reason = PERIOD_WORDS.get(word if requested is None else requested, "")
        if reason and (isolated := isolated_buildings(results.scene)):
            reason += f", of {' and '.join(isolated)} while isolators yield"
        if requested is None and not word:
            reason = ", which the motions are scaled to"
        reading = f"{curve.reading} The curve is that of {intensity_words(curve.name)}{reason}.".strip()
        return Shaking(intensity, curve, reading, fields)
    if requested is not None:
        intensity = resolved_intensity(results, requested)
    elif hazard_data is None:
        intensity = usual
    else:  # that of the curve
        measure = read_measure(hazard_data.name)
        intensity = measure.intensity if measure else usual
    return Shaking(intensity, hazard_data, hazard_data.reading if hazard_data else "", fields)


def intensities(results: Results, intensity: str) -> Array:
    """Intensities of the motions [SI], (motions, amplitudes).

    That is "pga", "pgv", "sa_avg(0.2-2 s)", the factor "scale" of a dataset whose axis it is, or "sa(left)",
    "sa(right)" or by name, or "sa(0.62 s)" at any period. What the dataset's motions are scaled to has the values of
    its axis. Sa of a building that without contact is an oscillator on the record (`_is_oscillator`) is exact, at its
    own period and damping: (2π/T)² times its largest displacement; of another it is that of the record at its first
    period. Sa at a period is what the scene scales its motions to where that is the same, or is read from the dataset's
    spectra, of 5 % damping, by straight lines in the logarithms. Raises PoundingError for another word, for a rigid
    building, and where the dataset has no such spectrum.
    """
    measure, side = measure_of(results, intensity)
    dataset, amplitudes = results.dataset, results.amplitudes
    if side is None and amplitudes.axis in dataset.coords and amplitudes.measure.is_same(measure):
        motions = dataset.sizes["record"] * dataset.sizes["polarity"]
        return np.tile(np.array(amplitudes.values, dtype=float), (motions, 1))
    if measure.name != "sa":
        pga = dataset["record_pga"].values
        if PGA_AXIS in dataset.coords:
            levels = np.tile(np.atleast_1d(dataset[PGA_AXIS].values), (pga.size, 1))
        elif LEVEL_AXIS in dataset.coords:
            levels = dataset["record_pga_felt"].transpose("record", ...).values.reshape(pga.size, -1)
        else:
            levels = pga[:, None]
        if measure.name != "pga":  # by factors from the records before the amplitude of the grid, 1 of still ground
            factors = np.divide(levels, pga[:, None], out=np.ones_like(levels), where=pga[:, None] > 0.0)
            levels = _before_scaling(results, measure, intensity)[:, None] * factors
        return np.repeat(levels, dataset.sizes["polarity"], axis=0)
    if side is not None and _is_oscillator(results, side):
        displacements = by_amplitude(dataset["peak_displacement_free"].isel(building=side))
        return displacements * (2.0 * np.pi / measure.period) ** 2
    scaling = results.scaled_to
    if scaling is not None and scaling.measure.is_same(measure):
        return np.full((dataset.sizes["record"] * dataset.sizes["polarity"], 1), scaling.value)
    _check_spectra(results, (measure,), intensity)
    spectral_values = np.exp(_log_spectra(results, np.array([measure.period]))[:, 0])
    ratios = spectral_values[:, None] / dataset["record_pga"].values[:, None]
    return np.asarray(np.repeat(ratios, dataset.sizes["polarity"], axis=0) * intensities(results, "pga"))


def _check_spectra(results: Results, required: Sequence[Measure], intensity: str) -> None:
    """Raise PoundingError where the dataset has no Sa of its records at these periods and damping."""
    if all(results.has_spectrum_at(measure) for measure in required):
        return
    span = results.spectral_range
    if span is None:
        raise PoundingError(
            f"intensity {intensity!r}: the dataset has no spectra of its records, an older version wrote it; run "
            "it again with `pounding-risk rerun`, or write pga"
        )
    periods = "a period" if len(required) == 1 else "periods"
    raise PoundingError(
        f"intensity {intensity!r}: the dataset has spectra of 5 % damping from {span[0]:.3g} s to {span[1]:.3g} s; "
        f"write {periods} among them, or pga"
    )


def _log_spectra(results: Results, at_periods: NDArray[Any]) -> Array:
    """Logarithms of Sa of the records before the amplitude of the grid at these periods, (records, periods)."""
    spectra = results.dataset["record_spectral_acceleration"].transpose("record", "period").values
    periods = np.log(results.dataset["period"].values)
    return np.array([np.interp(np.log(at_periods), periods, np.log(spectrum)) for spectrum in spectra])


def _before_scaling(results: Results, measure: Measure, intensity: str) -> Array:
    """PGV or mean Sa of the records before the amplitude of the grid, (records,) [SI]."""
    if measure.name == FACTOR:
        raise PoundingError(
            "intensity 'scale': the motions of the dataset are not scaled by factors; write what they are scaled to, "
            f"{results.usual_intensity}, or pga"
        )
    if measure.name == "pgv":
        if "record_pgv" not in results.dataset.coords:
            raise PoundingError(
                "intensity 'pgv': the dataset has no PGV of its records, an older version wrote it; run it again with "
                "`pounding-risk rerun`, or write pga"
            )
        return np.asarray(results.dataset["record_pgv"].values)
    periods = mean_periods(measure.periods[0], measure.periods[-1])
    # The ends as they are written: rounded by a power and a logarithm they may lie outside the spectra.
    periods[[0, -1]] = measure.periods
    _check_spectra(results, [sa_at(float(period), measure.damping) for period in periods], intensity)
    return np.exp(_log_spectra(results, periods).mean(axis=1))


def measure_of(results: Results, intensity: str) -> tuple[Measure, int | None]:
    """The measure of an intensity, and the index of the building whose own Sa it is; None of a stated period.

    Raises PoundingError for another word, and for a rigid building.
    """
    measure = read_measure(intensity)
    if measure is not None:
        return measure, None
    dataset, names = results.dataset, list(map(str, results.dataset["building"].values))
    match = re.fullmatch(r"sa\((.+)\)", intensity)
    label = match[1].strip() if match else ""
    sides = next((sides for sides in (["left", "right"], names) if label in sides), None)
    if sides is None:
        row_names = [str(table.get("name")) for table in results.scene.get("building", [])]
        reason = f"is that of {label}, which is not at every interface" if label in row_names else "is not known"
        choices_text = f"by name {', '.join(f'sa({name})' for name in names)}"
        if len(row_names) > len(names):  # one of several interfaces, which have no name in common
            choices_text = "sa(longer)"
        raise PoundingError(
            f"intensity {intensity!r} {reason}; write pga, sa(left), sa(right), {choices_text}, or a period such as "
            "sa(0.5 s); also pgv, or a range of periods such as sa_avg(0.2-2 s)"
        )
    side = sides.index(label)
    period = float(_periods(results)[side])
    if np.isnan(period):
        raise PoundingError(
            f"intensity {intensity!r}: that building is rigid and has no period; write pga, or the other building's sa"
        )
    if "building_damping" in dataset.variables and _is_oscillator(results, side):
        return sa_at(period, float(dataset["building_damping"].values[side])), side
    return sa_at(period), side


def _periods(results: Results) -> Array:
    """First periods of the buildings [s], of isolated ones while their isolators yield; NaN of rigid ones."""
    isolated = isolated_buildings(results.scene)
    if isolated and "building_isolated_period" not in results.dataset.coords:
        raise PoundingError(
            f"the dataset has no period of {' and '.join(isolated)} while isolators yield, an older version wrote it; "
            "run it again with `pounding-risk rerun`, or write the intensity by its period, such as sa(3 s)"
        )
    name = "building_isolated_period" if isolated else "building_period"
    return np.asarray(results.dataset[name].values, dtype=float)


def _is_oscillator(results: Results, side: int) -> bool:
    """True where a building without contact is one elastic mass, at rest at first, that the record alone moves."""
    dataset, scene = results.dataset, results.scene
    if "building_storeys" in dataset.coords and int(dataset["building_storeys"].values[side]) > 1:
        return False
    name, tables = str(dataset["building"].values[side]), scene.get("building", [])
    place = next((index for index, table in enumerate(tables) if table.get("name") == name), None)
    if place is None:  # the text of the scene is lost
        return True
    is_linked = any(results.has_link(index) for index in (place - 1, place) if 0 <= index < len(tables) - 1)
    has_known_keys = set(tables[place]) <= OF_OSCILLATORS and set(scene.get("effects", {})) <= WITHOUT_EFFECT
    return has_known_keys and not is_linked and name not in yielding_buildings(scene)


def resolved_intensity(results: Results, intensity: str) -> str:
    """The intensity with a period in place of "longer", "shorter" and "mean", those of the dataset's buildings.

    "mean" is the geometric mean of all periods. Raises PoundingError where all buildings are rigid.
    """
    match = re.fullmatch(r"sa\((longer|shorter|mean)\)", intensity)
    if match is None or match[1] in map(str, results.dataset["building"].values):
        return intensity
    periods = _periods(results)
    periods = periods[~np.isnan(periods)]
    if not periods.size:
        raise PoundingError(f"intensity {intensity!r}: every building is rigid and has no period; write pga")
    period = {"longer": periods.max(), "shorter": periods.min(), "mean": np.exp(np.log(periods).mean())}[match[1]]
    return sa_at(float(period)).intensity


def spectral_intensity(results: Results, intensity: str) -> str:
    """An intensity by its period: "sa(0.5 s)" of "sa(left)"; another measure as it is."""
    measure, side = measure_of(results, intensity)
    return intensity if side is None else measure.intensity


def check_intensity(results: Results, intensity: str, curve: str) -> None:
    """Raise PoundingError where a hazard curve, by its name, is not of the intensity that fragilities are against.

    A curve of Sa that names a period, as "sa(1.0 s)", must name that of the intensity, and its damping be the same.
    """
    kind = re.match(r"[a-z_]*", curve)
    if kind is None or kind[0] != intensity.partition("(")[0]:
        repair = f", such as --intensity {shlex.quote(curve)}" if read_measure(curve) else ""
        raise PoundingError(
            f"the hazard curve is one of {curve}, the fragility one against {intensity_words(intensity)}; write the "
            f"intensity that the curve is of{repair}"
        )
    measure, side = measure_of(results, intensity)
    of_curve = read_measure(curve)
    if measure.name == "sa_avg":
        _check_range(measure, of_curve, curve)
        return
    stated_period = re.search(r"\d*\.?\d+", curve)
    if measure.name != "sa" or stated_period is None:
        return
    period = measure.period
    if abs(float(stated_period[0]) - period) > NEAR * period:
        note = ", the building's own period" if side is not None else ""
        raise PoundingError(
            f"the hazard curve is one of {curve}, the fragility one against Sa at {period:.6g} s{note}; take the "
            "curve of that period, or the intensity that the curve is of"
        )
    if of_curve is not None and abs(of_curve.damping - measure.damping) > NEAR * of_curve.damping:
        raise PoundingError(
            f"the hazard curve is one of {curve} at {100.0 * of_curve.damping:g} % damping, the fragility one against "
            f"Sa at {100.0 * measure.damping:g} %; write --intensity {shlex.quote(sa_at(period).intensity)}, or name "
            f'the damping of the curve in its head, such as "sa({period:g} s, {100.0 * measure.damping:g} %) [g]"'
        )


def _check_range(measure: Measure, of_curve: Measure | None, curve: str) -> None:
    """Raise PoundingError where a hazard curve is of no mean Sa over the same periods, at the same damping."""
    if of_curve is None:
        raise PoundingError(
            f"the hazard curve is one of {curve}, whose periods cannot be read, the fragility one against "
            f"{measure.words}; write the head {measure.intensity} [g]"
        )
    pairs = [*zip(measure.periods, of_curve.periods, strict=True), (measure.damping, of_curve.damping)]
    if any(abs(value - curve_value) > NEAR * value for value, curve_value in pairs):
        raise PoundingError(
            f"the hazard curve is one of {of_curve.words}, the fragility one against {measure.words}; take the curve "
            f"of these periods and damping, or write --intensity {shlex.quote(of_curve.intensity)}"
        )
