"""Demands of the motions, read from a dataset of `scan`: closing without contact, yielding, intensities.

Nothing here runs a case; a dataset on disk is enough.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import FACTOR, LEVEL_AXIS, PGA_AXIS, Measure, read_measure
from pounding_risk.motions.processing.signals import LEAST_SHAKING
from pounding_risk.motions.record import recording
from pounding_risk.motions.scaling import mean_periods
from pounding_risk.results.amplitudes import (
    Spectral,
    amplitudes_of,
    has_spectrum_at,
    intensity_words,
    scaled_to,
    spectral,
    spectral_range,
    usual_intensity,
)
from pounding_risk.results.attributes import tables_of, told
from pounding_risk.results.check import AXES_OF_CASES, check_scan
from pounding_risk.results.files import open_results
from pounding_risk.results.kinds import kind_of
from pounding_risk.results.own_case import own_case, own_gaps, scene_place
from pounding_risk.results.selected_axes import with_axes
from pounding_risk.statistics.proportions import labels

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

AMPLITUDE_AXES = (PGA_AXIS, LEVEL_AXIS)  # of which a dataset has one at most
MOTION_AXES = ("record", "polarity", *AMPLITUDE_AXES)
NEEDED = ("peak_closing_free", "yield_exceedance", "impact_count", "status", "peak_displacement_free")
# They leave the free motion linear. inelastic_storeys does not: twice the motion is not twice the closing.
LINEAR = {"permanent_set", "unloading_stiffness", "strain_rate", "wave_passage", "p_delta", "soil_flexibility"}
SAME_GAP = 1e-9  # m, by which two gaps may differ that are one
NEAR = 0.05  # of a building's period, by which that of a hazard curve may differ: Sa hardly does
UNDEFINED = -1  # yield exceedance of a failed run, and where a jump has no force


class Motions(NamedTuple):
    """The motions of an ensemble, and how far each closes the gap without contact."""

    records: tuple[str, ...]  # by motion
    polarities: tuple[str, ...]
    recordings: NDArray[np.int64]  # numbers, equal for the components and polarities of one recording
    amplitudes: tuple[float | None, ...]  # SI, of the grid in its measure; None for motions as recorded
    closing: Array  # (motions, amplitudes) [m]
    finite: NDArray[np.bool_]  # (motions,) False where a closing is not finite at some amplitude, or the record is dead
    alone: Array | None = None  # of one interface of several: closing without contact anywhere, at most ``closing``


def open_dataset(results: xr.Dataset | str | Path) -> tuple[xr.Dataset, str]:
    """A dataset, or that of a file, with the axes of its cases, and the name by which errors call it."""
    source = str(results) if isinstance(results, str | Path) else "the dataset"
    return with_axes(open_results(results) if isinstance(results, str | Path) else results, source), source


def check_dataset(results: xr.Dataset, whose: str = "the dataset") -> None:
    """Raise PoundingError for what is no dataset of `scan`, for one of an older version, and for a damaged one."""
    kind = kind_of(results)
    if kind not in ("scan", ""):
        raise PoundingError(
            f"{whose}: is a dataset of `{kind}`, which has not the cases of a scan; assess takes what "
            "`pounding-risk scan SCENE -o results.nc` writes"
        )
    if "impact_count" not in results or not {"record", "gap"} <= set(results.dims):
        raise PoundingError(f"{whose}: is no dataset of a scan; `pounding-risk scan SCENE -o results.nc` writes one")
    missing = [name for name in NEEDED if name not in results]
    if missing:
        raise PoundingError(
            f"{whose}: has no {', '.join(missing)}: an older version wrote it, or it was damaged; scan the scene "
            "again, the scene's text is the attribute 'scene'"
        )
    if "scene_resolved" not in results.attrs:
        raise PoundingError(
            f"{whose}: has lost its attribute 'scene_resolved', which holds the scene; take the file that scan wrote"
        )
    check_scan(
        results,
        whose,
        names=(*AXES_OF_CASES, "building", "building_period", "building_damping"),
        attrs=("records", "title"),
    )


def interfaces(results: xr.Dataset) -> list[tuple[str, xr.Dataset]]:
    """Each pair of neighbours, named "left | right", and its part of the dataset, without the dimension of interfaces.

    ``gap`` is the interface's own. Where the grid varies another's gap, its own is one: beside that gap of the other
    which is nearest to the scene's.
    """
    return [(str(name), _one_interface(results, at)) for at, name in enumerate(results["interface"].values)]


def _one_interface(results: xr.Dataset, at: int) -> xr.Dataset:
    part = {"interface": at, "building": slice(at, at + 2)}
    if "contact_point" in results.dims:
        part["contact_point"] = np.flatnonzero(results["contact_point_interface"].values == at)
    gaps = own_gaps(results).isel(interface=at)
    if gaps.size > 1 and np.ptp(gaps.values) == 0.0:
        part["gap"] = slice(*(scene_place(results) + end for end in (0, 1)))
        gaps = gaps.isel(gap=part["gap"])
    return results.isel(part).assign_coords(gap=("gap", gaps.values, results["gap"].attrs))


def is_linear(results: xr.Dataset) -> bool:
    """True where the closing without contact is proportional to the motion, as no effect is nonlinear."""
    return set(tables_of(results.attrs["scene_resolved"]).get("effects", {})) <= LINEAR


def motions_of(results: xr.Dataset) -> Motions:
    """The motions of one interface, record by record and polarity by polarity.

    In a row what stands further along may push a building across a gap that the motion without contact leaves open:
    ``closing`` is then the most that is closed, with the penetration, in such a run under any contact model and F_E.
    """
    records, polarities = (list(map(str, results[axis].values)) for axis in ("record", "polarity"))
    closing = alone = _by_amplitude(results["peak_closing_free"])
    is_pushed = "impact_count" in results and "interior" in results["building_position"].values
    if is_pushed:
        opened = results["peak_closing_free"] <= results["gap"]
        reach = results["peak_closing"].where((results["impact_count"] > 0) & opened)
        pushed = reach.max([axis for axis in reach.dims if axis not in MOTION_AXES])
        closing = np.fmax(alone, _by_amplitude(pushed))  # NaN without such runs
    turns = len(polarities)
    return Motions(
        tuple(name for name in records for _ in polarities),
        tuple(polarities) * len(records),
        np.repeat(numbered_recordings(results, records), turns),
        amplitudes_of(results).values,
        closing,
        np.atleast_1d(np.isfinite(alone).all(axis=1)) & np.repeat(is_shaking(results), turns),
        alone if is_pushed else None,
    )


def numbered_recordings(results: xr.Dataset, records: Sequence[str]) -> NDArray[np.int64]:
    """The number of each record's recording; records whose motion is the same to the last bit are of one."""
    facts = {entry.get("name"): entry for entry in told(results, "records", [])}
    of_records: list[Any] = [recording(facts.get(name, {}), name) for name in records]
    shared = [tuple(one) if isinstance(one, list) else one for one in of_records]
    digests = told(results, "motions_sha256", {})
    first: dict[Any, Any] = {}
    for index, name in enumerate(records):
        key, original = shared[index], first.setdefault(digests.get(name, name), shared[index])
        if key != original:
            shared = [original if entry == key else entry for entry in shared]
            first = {digest: original if entry == key else entry for digest, entry in first.items()}
    return labels(shared)


def record_doubts(results: xr.Dataset) -> tuple[str, ...]:
    """A sentence for each record that is a copy of another, as `scan` found it, is here twice, or holds no motion."""
    digests = told(results, "motions_sha256", {})
    names = list(map(str, results["record"].values))
    first: dict[str, str] = {}
    twice = []
    for name in names:
        original = first.setdefault(digests.get(name, name), name)
        if original != name:
            twice.append(f"{name} holds the same motion as {original}: it counts twice in the shares, scan again")
    dead = [name for name, shakes in zip(names, is_shaking(results), strict=True) if not shakes]
    still = [f"{name} holds no motion: it counts against the verdict, scan again without it" for name in dead]
    return (*told(results, "copies", []), *twice, *still)


def is_shaking(results: xr.Dataset) -> NDArray[np.bool_]:
    """Whether each record holds a motion; datasets of older versions may have records that do not."""
    if "record_pga" not in results.coords:
        return np.ones(results.sizes["record"], dtype=bool)
    return np.asarray(results["record_pga"].values >= LEAST_SHAKING)


def touching(results: xr.Dataset, motions: Motions, gap: float) -> NDArray[np.bool_]:
    """Whether each motion brings contact at a gap, (motions, amplitudes).

    Of a pair that is what it closes. In a row contact elsewhere may push buildings together or keep them from meeting:
    at a gap of the grid it is what the run with all neighbours does, under the scene's own contact model and F_E, as
    `row.row_case` has it. At another gap, and where that run failed, it is ``closing`` of `motions_of`.
    """
    closes = motions.closing > gap
    at = np.flatnonzero(np.isclose(results["gap"].values, gap, rtol=0.0, atol=SAME_GAP))
    if motions.alone is None or not at.size:
        return closes
    cell = {name: place for name, place in own_case(results).items() if name in ("contact_model", "yield_force")}
    counts = _by_amplitude(results["impact_count"].isel(cell | {"gap": int(at[0])}))
    return np.asarray(np.where(counts == UNDEFINED, closes, counts > 0))


def by_motion(values: xr.DataArray, rest: Sequence[str] = ()) -> Array:
    """Values as (motions, ...), the axes ``rest`` in this order."""
    ordered = values.variable.transpose("record", "polarity", *rest).values  # without the coordinates, a copy of each
    return np.asarray(ordered.reshape(ordered.shape[0] * ordered.shape[1], *ordered.shape[2:]))


def _by_amplitude(values: xr.DataArray) -> Array:
    """Values as (motions, amplitudes), whether or not there is an axis of amplitudes."""
    axes = [axis for axis in AMPLITUDE_AXES if axis in values.dims]
    flat = by_motion(values, axes)
    return flat.reshape(len(flat), -1)


def yields_of(results: xr.Dataset, gap: float) -> tuple[float, Array]:
    """Nearest gap of the grid, and whether each run yields there: (motions, amplitudes, models, finite yield forces).

    1 and 0; NaN where the run failed or yielding is not defined, as of an instant jump.
    """
    gaps = results["gap"].values
    nearest = int(np.abs(gaps - gap).argmin())
    one = results["yield_exceedance"].isel(gap=nearest, yield_force=_may_yield(results))
    rest = [axis for axis in (*AMPLITUDE_AXES, "contact_model", "yield_force") if axis in one.dims]
    values = by_motion(one, rest)
    values = values if set(AMPLITUDE_AXES) & set(rest) else values[:, None]
    return float(gaps[nearest]), np.where(values == UNDEFINED, np.nan, values.astype(float))


def finite_forces(results: xr.Dataset) -> Array:
    """The grid's yield forces [N] without inf, which never yields, unless columns have a yield force of their own."""
    return np.asarray(results["yield_force"].values[_may_yield(results)])


def _may_yield(results: xr.Dataset) -> NDArray[np.bool_]:
    """Yield forces of the grid under which some contact may yield, as a mask."""
    if "contact_point_yield_force" not in results.variables:
        return np.asarray(np.isfinite(results["yield_force"].values))
    # By the grid's yield force where floors meet; a column keeps its own.
    own = results.variables["contact_point_yield_force"]
    sizes = {"yield_force": results.sizes["yield_force"], "contact_point": results.sizes["contact_point"]}
    return np.asarray(np.isfinite(own.set_dims(sizes).transpose(*sizes).values).any(axis=1))


def intensities(results: xr.Dataset, intensity: str) -> Array:
    """Intensities of the motions [SI], (motions, amplitudes).

    That is "pga", "pgv", "sa_avg(0.2-2 s)", the factor "scale" of a dataset whose axis it is, or "sa(left)",
    "sa(right)" or by name, or "sa(0.62 s)" at any period. What the dataset's motions are scaled to has the values of
    its axis. Sa of a single mass is its pseudo-spectral acceleration at its own period and damping, (2π/T)² times its
    largest displacement without contact; of a building with storeys, that of the record at its first period. Sa at a
    period is what the scene scales its motions to where that is the same, or is read from the dataset's spectra, of
    5 % damping, by straight lines in the logarithms. Raises PoundingError for another word, for a rigid building, and
    where the dataset has no such spectrum.
    """
    measure = read_measure(intensity)
    amplitudes = amplitudes_of(results)
    if measure is not None and amplitudes.axis in results.coords and amplitudes.measure.is_same(measure):
        motions = results.sizes["record"] * results.sizes["polarity"]
        return np.tile(np.array(amplitudes.values, dtype=float), (motions, 1))
    if measure is not None and measure.name != "sa":
        before = results["record_pga"].values
        if PGA_AXIS in results.coords:
            felt = np.tile(np.atleast_1d(results[PGA_AXIS].values), (before.size, 1))
        elif LEVEL_AXIS in results.coords:
            felt = results["record_pga_felt"].transpose("record", ...).values.reshape(before.size, -1)
        else:
            felt = before[:, None]
        if measure.name != "pga":  # by factors from the records before the amplitude of the grid, 1 of still ground
            grown = np.divide(felt, before[:, None], out=np.ones_like(felt), where=before[:, None] > 0.0)
            felt = _before_scaling(results, measure, intensity)[:, None] * grown
        return np.repeat(felt, results.sizes["polarity"], axis=0)
    one = _spectral_of(results, intensity)
    side = _side(results, intensity)
    if side is not None and not _has_storeys(results, side):
        free = _by_amplitude(results["peak_displacement_free"].isel(building=side))
        return free * (2.0 * np.pi / one.period) ** 2
    known = scaled_to(results)
    if known is not None and known.value is not None and known.is_at(one):
        return np.full((results.sizes["record"] * results.sizes["polarity"], 1), known.value)
    _check_spectra(results, (one,), intensity)
    at = np.exp(_log_spectra(results, np.array([one.period]))[:, 0])
    scaled = at[:, None] / results["record_pga"].values[:, None]
    return np.asarray(np.repeat(scaled, results.sizes["polarity"], axis=0) * intensities(results, "pga"))


def _check_spectra(results: xr.Dataset, required: Sequence[Spectral], intensity: str) -> None:
    """Raise PoundingError where the dataset has no Sa of its records at these periods and damping."""
    if all(has_spectrum_at(results, one) for one in required):
        return
    span = spectral_range(results)
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


def _log_spectra(results: xr.Dataset, at: NDArray[Any]) -> Array:
    """Logarithms of Sa of the records before the amplitude of the grid at these periods, (records, periods)."""
    spectra, periods = results["record_spectral_acceleration"].transpose("record", "period").values, results["period"]
    return np.array([np.interp(np.log(at), np.log(periods.values), np.log(spectrum)) for spectrum in spectra])


def _before_scaling(results: xr.Dataset, measure: Measure, intensity: str) -> Array:
    """PGV or mean Sa of the records before the amplitude of the grid, (records,) [SI]."""
    if measure.name == FACTOR:
        raise PoundingError(
            "intensity 'scale': the motions of the dataset are not scaled by factors; write what they are scaled to, "
            f"{usual_intensity(results)}, or pga"
        )
    if measure.name == "pgv":
        if "record_pgv" not in results.coords:
            raise PoundingError(
                "intensity 'pgv': the dataset has no PGV of its records, an older version wrote it; run it again with "
                "`pounding-risk rerun`, or write pga"
            )
        return np.asarray(results["record_pgv"].values)
    periods = mean_periods(measure.periods[0], measure.periods[-1])
    # The ends as they are written: what a power and a logarithm make of them may lie outside the spectra.
    periods[[0, -1]] = measure.periods
    _check_spectra(results, [Spectral(float(period), measure.damping) for period in periods], intensity)
    return np.exp(_log_spectra(results, periods).mean(axis=1))


def _spectral_of(results: xr.Dataset, intensity: str) -> Spectral:
    """Period and damping of the requested Sa; raises PoundingError for a rigid building's."""
    side = _side(results, intensity)
    if side is None:
        return spectral(intensity[3:-1]) or Spectral(np.nan)
    period = float(results["building_period"].values[side])
    if np.isnan(period):
        raise PoundingError(
            f"intensity {intensity!r}: that building is rigid and has no period; write pga, or the other building's sa"
        )
    if _has_storeys(results, side) or "building_damping" not in results.variables:
        return Spectral(period)
    return Spectral(period, float(results["building_damping"].values[side]))


def _has_storeys(results: xr.Dataset, side: int) -> bool:
    return "building_storeys" in results.coords and int(results["building_storeys"].values[side]) > 1


def resolved_intensity(results: xr.Dataset, intensity: str) -> str:
    """The intensity with a period in place of "longer", "shorter" and "mean", those of the dataset's buildings.

    "mean" is the geometric mean of all periods. Raises PoundingError where all buildings are rigid.
    """
    match = re.fullmatch(r"sa\((longer|shorter|mean)\)", intensity)
    if match is None or match[1] in map(str, results["building"].values):
        return intensity
    periods = results["building_period"].values
    periods = periods[np.isfinite(periods)]
    if not periods.size:
        raise PoundingError(f"intensity {intensity!r}: every building is rigid and has no period; write pga")
    chosen = {"longer": periods.max(), "shorter": periods.min(), "mean": np.exp(np.log(periods).mean())}[match[1]]
    return Spectral(float(chosen)).intensity


def spectral_intensity(results: xr.Dataset, intensity: str) -> str:
    """An intensity by its period: "sa(0.5 s)" of "sa(left)"; another measure as it is."""
    measure = read_measure(intensity)
    return intensity if measure is not None else _spectral_of(results, intensity).intensity


def check_intensity(results: xr.Dataset, intensity: str, curve: str) -> None:
    """Raise PoundingError where a hazard curve, by its name, is not of the intensity that fragilities are against.

    A curve of Sa that names a period, as "sa(1.0 s)", must name that of the intensity, and its damping be the same.
    """
    kind = re.match(r"[a-z_]*", curve)
    if kind is None or kind[0] != intensity.partition("(")[0]:
        known = read_measure(curve) is not None or spectral(curve[3:-1])
        repair = f", such as --intensity {shlex.quote(curve)}" if known else ""
        raise PoundingError(
            f"the hazard curve is one of {curve}, the fragility one against {intensity_words(intensity)}; write the "
            f"intensity that the curve is of{repair}"
        )
    own_measure, of_hazard = read_measure(intensity), read_measure(curve)
    if own_measure is not None and own_measure.name == "sa_avg":
        _check_range(own_measure, of_hazard, curve)
        return
    named = re.search(r"\d*\.?\d+", curve)
    if (own_measure is not None and own_measure.name != "sa") or named is None:
        return
    own, of_curve = _spectral_of(results, intensity), spectral(curve[3:-1])
    period = own.period
    if abs(float(named[0]) - period) > NEAR * period:
        whose = ", the building's own period" if _side(results, intensity) is not None else ""
        raise PoundingError(
            f"the hazard curve is one of {curve}, the fragility one against Sa at {period:.6g} s{whose}; take the "
            "curve of that period, or the intensity that the curve is of"
        )
    if of_curve is not None and abs(of_curve.damping - own.damping) > NEAR * of_curve.damping:
        raise PoundingError(
            f"the hazard curve is one of {curve} at {100.0 * of_curve.damping:g} % damping, the fragility one against "
            f"Sa at {100.0 * own.damping:g} %; write --intensity {shlex.quote(Spectral(period).intensity)}, or name "
            f'the damping of the curve in its head, such as "sa({period:g} s, {100.0 * own.damping:g} %) [g]"'
        )


def _check_range(own: Measure, of_curve: Measure | None, curve: str) -> None:
    """Raise PoundingError where a hazard curve is of no mean Sa over the same periods, at the same damping."""
    if of_curve is None:
        raise PoundingError(
            f"the hazard curve is one of {curve}, whose periods cannot be read, the fragility one against {own.words}; "
            f"write the head {own.intensity} [g]"
        )
    pairs = [*zip(own.periods, of_curve.periods, strict=True), (own.damping, of_curve.damping)]
    if any(abs(one - other) > NEAR * one for one, other in pairs):
        raise PoundingError(
            f"the hazard curve is one of {of_curve.words}, the fragility one against {own.words}; take the curve of "
            f"these periods and damping, or write --intensity {shlex.quote(of_curve.intensity)}"
        )


def _side(results: xr.Dataset, intensity: str) -> int | None:
    """Index of the building whose Sa is requested; None for the Sa at a period. Raises PoundingError for neither."""
    names = [str(name) for name in results["building"].values]
    match = re.fullmatch(r"sa\((.+)\)", intensity)
    inside = match[1].strip() if match else ""
    for known in (["left", "right"], names):
        if inside in known:
            return known.index(inside)
    if inside and spectral(inside) is not None:
        return None
    listed = ", ".join(f"sa({name})" for name in names)
    raise PoundingError(
        f"intensity {intensity!r} is not known; write pga, sa(left), sa(right), by name {listed}, or a period such as "
        "sa(0.5 s); also pgv, or a range of periods such as sa_avg(0.2-2 s)"
    )


def run_counts(results: xr.Dataset) -> dict[str, int]:
    """Numbers of cases: all, simulated, failed, recomputed at a tighter tolerance, and sensitive among these."""
    status = results["status"]
    meanings = str(status.attrs["flag_meanings"]).split()
    complete = np.atleast_1d(status.attrs["flag_values"])[meanings.index("complete")]
    flags = results["sensitive"].values if "sensitive" in results else np.full(1, -1)
    return {
        "cases": int(status.size),
        "simulated": int((results["simulated"].values == 1).sum()) if "simulated" in results else int(status.size),
        "failed": int((status.values != complete).sum()),
        "checked": int((flags >= 0).sum()),
        "sensitive": int((flags == 1).sum()),
    }
