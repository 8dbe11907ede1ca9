"""Variables, coordinates and attributes of the datasets of a scene."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import accumulate, pairwise
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.plugins import GROUPS
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.effects import EFFECTS, acts_on_law, bare, references
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.motions.intensity import LEAST_PERIOD, response_spectra
from pounding_risk.motions.levels import PEAK, Measure
from pounding_risk.motions.motion import USUAL_FACTORS, Motion, unit_doubts
from pounding_risk.motions.record import AFTERSHOCK, GENERATED, recording_numbers
from pounding_risk.motions.scaling import peak_velocities
from pounding_risk.results.attributes import DATASET_VERSION, VERSION, as_text, versions
from pounding_risk.results.layout import AMPLITUDE, CaseVariable, axes_by
from pounding_risk.results.variables import coordinates, described, own_dims
from pounding_risk.scene.ground_motion import parting
from pounding_risk.scene.interfaces import said_restitution
from pounding_risk.scene.notes import level_notes, unused_keys
from pounding_risk.scene.scene import Scene, plugins_of
from pounding_risk.scene.scene_axis import SAMPLE
from pounding_risk.scene.uncertain import DrawnMotions
from pounding_risk.scene.values import OF_EACH_INTERFACE
from pounding_risk.solver.counters import USUAL_SENTENCES

if TYPE_CHECKING:
    import xarray as xr

PERIODS = np.geomspace(0.05, 5.0, 60)  # s, of the records' spectra
CONVENTIONS = "CF-1.11"  # that the datasets follow
NEEDED = "gap that the motion needs: largest u_left - u_right of the continuous motion without contact"
WITH_BUMPERS = ", and the length of the bumpers"
TO_COLLAPSE = "; up to the collapse of a storey, where one collapses, for which no gap is wide enough"
Array = np.ndarray
Laws = Sequence[Sequence[Any]]  # of each contact model, that of each interface


def skeleton(
    study: Scene, motions: tuple[Motion, ...], free: Mapping[str, tuple[Any, Array]], coords: Mapping[str, Any]
) -> xr.Dataset:
    """The dataset of a scan without its cases and attributes.

    ``free`` are outputs of the motions without contact by name: the output, with its unit and words, and its values by
    record, polarity, amplitude and its own dimensions. ``coords`` are those of `places_of`.
    """
    import xarray as xr  # the size of a dataset is known without it

    from pounding_risk.results import accessor as accessor  # registers it with xarray

    words = NEEDED + WITH_BUMPERS * bool(study.bumpers)
    words += TO_COLLAPSE * ("inelastic_storeys" in dict(study.effects))
    variables: dict[str, Any] = {
        f"{name}_free": (
            (*axes_of_motions(study), *own_dims(f"{name}_free")),
            values,
            described(output.unit, words if name.endswith("peak_closing") else f"{output.words}; without contact"),
        )
        for name, (output, values) in free.items()
    }
    labels = case_coordinates(study, motions) | dict(coords)
    return one_amplitude(xr.Dataset(variables | motion_spectra(motions), coords=labels), study)


def places_of(study: Scene, gaps: Array, yield_forces: Array, whole: bool = False) -> dict[str, Any]:
    """Interfaces, contact points, buildings and storeys of a scene, with facts on each.

    ``gaps`` [m] are those of the grid at each interface, ``yield_forces`` [N] those at each contact point. Of a
    ``whole`` one no coordinate is left out because it is equal to another.
    """
    coords = building_coordinates(study.buildings) | place_coordinates(study.buildings, study.points, yield_forces)
    coords |= bumper_coordinate(study)
    if whole or (gaps != np.array(study.grid.gaps)[:, None]).any():
        of_axis = study.gridded_interface or "the scene's first one"
        words = f"clear distance at rest of each interface; the axis gap is that of {of_axis}"
        coords |= coordinates({"interface_gap": (gaps, words)})
    if OF_EACH_INTERFACE in study.grid.contact_models:
        names = [interface.contact_model for interface in study.interfaces]
        coords["interface_contact_model"] = (("interface",), names, {"long_name": "contact model of the interface"})
    return coords


def place_coordinates(buildings: Sequence[Any], points: Sequence[Point], yield_forces: np.ndarray) -> dict[str, Any]:
    """Labels of the places and facts on each, as xarray takes them.

    ``buildings`` are `Building` or `Storeys`, ``yield_forces`` [N] those of the grid at each contact point.
    """
    names = [building.name for building in buildings]
    interfaces = [f"{left} | {right}" for left, right in pairwise(names)]
    labels = [_label(point, names) for point in points]
    facts = {
        "interface": "index of the contact point's interface, from 0",
        "level": "level above the ground; NaN where not known",
        "kind": "kind of contact point: two floors, or a floor and a column",
        "left_floor": "floor of the left building",
        "right_floor": "floor of the right building",
    }
    of_points = {
        f"contact_point_{fact}": ([getattr(point, fact) for point in points], words) for fact, words in facts.items()
    }
    return coordinates(
        {
            "interface": (interfaces, "neighbours, left | right"),
            "contact_point": (labels, "contact point: the floors at which two neighbours meet, left | right"),
            **of_points,
            "contact_point_yield_force": (yield_forces, "yield force F_E at the contact point; inf never yields"),
            **_of_buildings(buildings),
        }
    )


def bumper_coordinate(study: Scene) -> dict[str, Any]:
    """What bumpers take up of the gap of each interface; nothing of a scene without the key."""
    if not study.bumpers:
        return {}
    words = "length of the bumpers in the gap, counted in closings of the gap"
    return coordinates({"interface_bumper": (list(study.bumpers), words)})


def building_coordinates(buildings: Sequence[Any]) -> dict[str, Any]:
    """Mass, first period and damping of each building; NaN for a rigid one."""
    facts = {}
    for name, words in (("mass", "mass"), ("period", "first period of vibration"), ("damping", "damping ratio")):
        column = [np.nan if building.is_rigid else getattr(building, name) for building in buildings]
        facts[f"building_{name}"] = column, f"{words} of the building"
    if any(getattr(building, "isolators", None) is not None for building in buildings):
        yielding = [
            np.nan if building.is_rigid else getattr(building, "isolated_period", building.period)
            for building in buildings
        ]
        facts["building_isolated_period"] = yielding, "first period of the building, while any isolators below it yield"
    return coordinates(facts)


def _label(point: Point, names: Sequence[str]) -> str:
    """Such as "A 2 | B 2", "A 2 | B 1.4" where a floor of A meets a column of B, "A 2 | B 2 at 8 m" of a face."""
    left, right = names[point.interface], names[point.interface + 1]
    across = "" if point.across == inf else f" at {point.across:.3g} m"
    return f"{left} {point.left_floor:.3g} | {right} {point.right_floor:.3g}{across}"


def _of_buildings(buildings: Sequence[Any]) -> dict[str, tuple[Any, str]]:
    """Facts on each building and its storeys; NaN where a rigid one, or one without storeys, has no such value."""
    # A single mass counts as one storey.
    storeys = [0 if building.is_rigid else len(getattr(building, "masses", (building.mass,))) for building in buildings]
    levels = np.full((len(buildings), max(1, *storeys)), np.nan)
    for place, building in enumerate(buildings):
        own_levels = list(accumulate(building.heights))
        levels[place, : len(own_levels)] = own_levels
    heights = [building.height if building.height > 0.0 else np.nan for building in buildings]
    return {
        "building_height": (heights, "level of the roof; NaN where not given"),
        "building_storeys": (storeys, "storeys; a rigid building has none"),
        "building_position": (positions(len(buildings)), "position of the building in the row: end or interior"),
        "storey": (np.arange(levels.shape[1]) + 1, "storey, from the ground up"),
        "floor_level": (levels, "level of the floor above the storey; NaN where not given"),
    }


def positions(count: int) -> list[str]:
    """Position of each of so many buildings: end or interior, or alone."""
    return ["alone"] if count == 1 else ["end", *["interior"] * (count - 2), "end"]


def case_variable(name: str, output: Any) -> CaseVariable:
    """An output of a solver, with its unit and words, as a variable of a dataset; a count or flag has ``whole``."""
    return CaseVariable(own_dims(name), kept_as(getattr(output, "whole", False)), described(output.unit, output.words))


def one_amplitude(dataset: xr.Dataset, study: Scene) -> xr.Dataset:
    """Remove the axis of amplitudes of a scan of one amplitude; it stays as a label, where there is one."""
    grid = study.grid
    if len(grid.amplitudes) > 1:
        return dataset
    return dataset.squeeze(grid.measure.axis, drop=grid.amplitudes == (None,))


def axes_of_motions(study: Scene) -> tuple[str, ...]:
    """The axes of the motions of a scan: record, polarity and amplitude."""
    return axes_by(study.grid.measure.axis)[: AMPLITUDE + 1]


def kept_as(whole: bool) -> np.dtype[Any]:
    """The type in which a variable is stored."""
    return np.dtype(np.int32) if whole else np.dtype(np.float64)


def status_variable(sentences: Mapping[int, str]) -> CaseVariable:
    """How the run of each case ended, by the codes of these sentences."""
    about = {
        "long_name": "how the run ended",
        "flag_values": np.array(list(sentences), dtype=np.int8),
        "flag_meanings": " ".join("_".join(re.findall(r"[^\W_]+", sentence)) for sentence in sentences.values()),
        "sentences": as_text({str(code): sentence for code, sentence in sentences.items()}),
    }
    return CaseVariable((), np.dtype(np.int8), about)


# How the run of each case ended, and whether the case was simulated.
OUTCOME = {
    "status": status_variable(USUAL_SENTENCES),
    "simulated": CaseVariable(
        (),
        np.dtype(np.int8),
        {"long_name": "1 where the case was simulated, 0 where the result follows exactly from another run"},
    ),
}


def with_drawn_motions(
    dataset: xr.Dataset, study: Scene, motions: tuple[Motion, ...], drawn: DrawnMotions
) -> xr.Dataset:
    """A dataset along samples with the facts on the motion of each in place of its axes of records and polarities.

    ``record`` and ``polarity`` are then labels along ``sample``, and so is what is known of a record. The dataset has
    one place along these axes, where it has them; ``motions`` are all from which those of ``drawn`` are drawn.
    """
    import xarray as xr

    labels = case_coordinates(study, motions)
    axes = {"record", "polarity"}
    of_motions = {name: label for name, label in labels.items() if axes & set(np.atleast_1d(label[0]))}
    axis = study.grid.measure.axis
    facts = xr.Dataset(motion_spectra(motions), of_motions | {axis: labels[axis], "period": labels["period"]})
    places = {"record": drawn.records, "polarity": drawn.polarities}
    facts = one_amplitude(facts, study).isel({name: xr.DataArray(at, dims=SAMPLE) for name, at in places.items()})
    bare = dataset.drop_vars([name for name in facts.variables if name in dataset.variables])
    return bare.isel(dict.fromkeys(axes & set(bare.dims), 0)).merge(facts, join="exact")


def motion_spectra(motions: tuple[Motion, ...]) -> dict[str, Any]:
    """Spectra of the records; NaN at periods that are too short for the time step of a record."""
    valid = LEAST_PERIOD * max(motion.dt for motion in motions) <= PERIODS
    spectra = np.full((len(motions), PERIODS.size), np.nan)
    spectra[:, valid] = response_spectra(
        [motion.reaching(0.0).acceleration for motion in motions], [motion.dt for motion in motions], PERIODS[valid]
    ).pseudo_acceleration
    words = (
        "pseudo-spectral acceleration of the record after processing and scaling by the scene, before the amplitude "
        "of the grid; damping 5 %"
    )
    return {"record_spectral_acceleration": (("record", "period"), spectra, described("m/s2", words))}


def case_coordinates(study: Scene, motions: tuple[Motion, ...]) -> dict[str, Any]:
    """The axes of the cases, facts on the records, names of the buildings, and periods of the spectra."""

    def about(key: str) -> list[str]:
        return [str(motion.record.get(key, "")) for motion in motions]

    grid, axis = study.grid, study.grid.measure.axis
    levels = [np.nan if level is None else level for level in grid.levels]
    axes: dict[str, tuple[Any, str]] = {
        "record": ([motion.name for motion in motions], "ground motion"),
        "polarity": (list(study.records.polarities), "sign of the ground motion"),
    }
    other_axes = {
        "contact_model": (list(grid.contact_models), "contact law"),
        "gap": (list(grid.gaps), "clear distance at rest"),
        "yield_force": (list(grid.yield_forces), "yield force F_E; inf never yields"),
        "building": ([building.name for building in study.buildings], "building, left to right"),
        "period": (PERIODS, "period of an oscillator"),
        "record_event": (about("event"), "earthquake that the record is of"),
        "record_sha256": (about("sha256"), "checksum of the record's file"),
        **_record_facts(motions),
        **_amplitudes_felt(study, motions),
    }
    amplitudes = {axis: (axis, levels, measure_attributes(grid.measure))}
    widenings = ground_widenings(study, motions) if study.supports else {}
    return coordinates(axes) | amplitudes | coordinates(other_axes, axis) | widenings


def measure_attributes(measure: Measure) -> dict[str, Any]:
    """What a dataset says of the measure of its amplitudes: unit, words, and, but of PGA, what it is read back from."""
    facts: dict[str, Any] = dict(described(measure.unit, measure.long_name))
    if measure == PEAK:
        return facts
    of_oscillators = {"periods": list(measure.periods), "damping": measure.damping} if measure.periods else {}
    return facts | {"measure": measure.name, **of_oscillators}


def _record_facts(motions: tuple[Motion, ...]) -> dict[str, tuple[Any, str]]:
    """Magnitude, distance, vs30 and recording of each record; NaN where not known."""

    def known(key: str) -> list[float]:
        facts = [motion.record.get(key) for motion in motions]
        return [np.nan if fact in (None, "") else float(fact) for fact in facts]

    numbers = recording_numbers([motion.record for motion in motions], [motion.name for motion in motions])
    station = "distance of the station from the earthquake, of the kind that the catalogue states"
    recording = "number of the recording that the record is a component or a copy of, from 0"
    velocity = "peak ground velocity of the record, from rest, at the peak acceleration `record_pga`"
    return {
        "record_magnitude": (known("magnitude"), "magnitude of the earthquake that the record is of"),
        "record_distance": (known("distance_km"), station),
        "record_vs30": (known("vs30"), "mean shear-wave velocity of the upper 30 m under the record's station"),
        "record_recording": (numbers, recording),
        "record_pgv": (peak_velocities(motions), velocity),
    }


def _amplitudes_felt(study: Scene, motions: tuple[Motion, ...]) -> dict[str, tuple[Any, str]]:
    """PGA of each record before and after scaling to the grid's amplitude, and the factor of all scaling together."""
    peaks = np.array([motion.pga for motion in motions])
    factors = np.array([motion.record.get("factor", 1.0) for motion in motions])
    felt, gains = _felt_pga(study, motions, peaks)
    stage = "after processing and scaling by the scene, before the amplitude of the grid"
    factor = "factor on the processed record, of scaling by the scene and by the amplitude of the grid together"
    return {
        "record_pga": (peaks, f"peak acceleration of the record {stage}"),
        "record_pga_felt": (felt, "peak ground acceleration that the buildings felt, after every scaling"),
        "record_scale_factor": (factors[:, None] * gains, factor),
    }


def _felt_pga(study: Scene, motions: tuple[Motion, ...], peaks: Array) -> tuple[Array, Array]:
    """PGA [m/s²] of each motion at each amplitude of the grid, and the factor to it: (motions, amplitudes)."""
    levels = np.array([np.nan if level is None else level for level in study.grid.levels])
    if study.grid.measure == PEAK:
        felt = np.where(np.isnan(levels), peaks[:, None], levels)
        # Still ground is not scaled.
        return felt, np.divide(felt, peaks[:, None], out=np.ones_like(felt), where=peaks[:, None] > 0.0)
    intensities = study.grid.measure.of(motions)[:, None]
    gains = np.divide(levels, intensities, out=np.ones((len(motions), levels.size)), where=intensities > 0.0)
    return peaks[:, None] * gains, gains


def ground_widenings(study: Scene, motions: tuple[Motion, ...]) -> dict[str, Any]:
    """How far the grounds part at each interface under each record, before the amplitude of the grid."""
    partings = [parting(study, motion) for motion in motions]
    largest = np.array([ground_parting.largest for ground_parting in partings]).reshape(len(motions), -1)
    end = np.array([ground_parting.end for ground_parting in partings]).reshape(len(motions), -1)
    widening = "x_right - x_left of the grounds under neighbours, before the amplitude of the grid"
    return coordinates(
        {
            "record_ground_widening_largest": (largest, f"largest size of {widening}"),
            "record_ground_widening_end": (end, f"{widening}: at the end of the run"),
        }
    )


def sources_of(study: Scene, laws: Iterable[Any]) -> list[str]:
    """References of these laws and of the effects of the scene."""
    kinds = [EFFECTS[effect.name] for effect in study.effects if not acts_on_law(effect.name)]
    return list(dict.fromkeys([*map(references, laws), *(kind.reference for kind in kinds)]))


def attributes(study: Scene, motions: tuple[Motion, ...], laws: Laws, solver: str) -> dict[str, Any]:
    """Attributes of a scan: all that it takes to repeat it, and the references of its laws.

    ``solver`` is its name, "pair" or "row".
    """
    return {
        "Conventions": CONVENTIONS,
        "title": study.name,
        "source": f"pounding_risk: event-driven {solver} solver",
        **made_from(study, motions),
        **numbers_of(study, laws),
        **flags_of(study, motions),
    }


def flags_of(study: Scene, motions: tuple[Motion, ...]) -> dict[str, str]:
    """The attribute of doubts about motions, for those that have any."""
    return {"flags": as_text({name: doubts for name, doubts in doubts_of(study, motions).items() if doubts})}


def doubts_of(study: Scene, motions: tuple[Motion, ...]) -> dict[str, tuple[str, ...]]:
    """Doubts about each motion, some of which follow from the buildings, and on its factors to the amplitudes."""
    gains = _felt_pga(study, motions, np.array([motion.pga for motion in motions]))[1]
    unusual = _unusual_factors(study, motions, gains)
    return {
        motion.name: (*motion.flags, *unusual.get(motion.name, ()), *_unusual_aftershock(motion, of_motion))
        for motion, of_motion in zip(motions, gains, strict=True)
    }


def _unusual_aftershock(motion: Motion, gains: Array) -> Iterator[str]:
    """Flags of an aftershock that factors of its own, or those to the amplitudes of the grid, take beyond the usual."""
    shock = motion.record.get(AFTERSHOCK)
    if shock is None:
        return
    factors = shock["times"] * motion.record.get("factor", 1.0) * gains
    ends = dict.fromkeys((float(factors.min()), float(factors.max())))
    low, high = USUAL_FACTORS
    is_own = shock["times"] != 1.0 and shock.get("state") != GENERATED  # else the flag of its motion holds for it
    if is_own and not all(low <= factor <= high for factor in ends):
        words = " to ".join(f"{factor:.4g}" for factor in ends)
        is_outside = f"the scale factor {words} is" if len(ends) == 1 else f"scale factors {words} are"
        yield f"{shock['name']}, after it: {is_outside} outside {low:g} to {high:g}"
    for factor in ends:
        doubts = unit_doubts(factor * shock["pga"], "after scaling") if factor != 1.0 else ()
        yield from (f"{shock['name']}, after it: {doubt}" for doubt in doubts)


def _unusual_factors(study: Scene, motions: tuple[Motion, ...], gains: Array) -> dict[str, tuple[str]]:
    """The flag of each motion that some amplitude of the grid scales beyond the usual factors: one for all of them."""
    factors = gains * np.array([motion.record.get("factor", 1.0) for motion in motions])[:, None]
    low, high = USUAL_FACTORS
    unusual = ((gains != 1.0) & ((factors < low) | (factors > high))).any(axis=1)  # of a motion as it is: its own flag
    is_record = np.array([motion.record.get("state") != GENERATED for motion in motions], dtype=bool)
    unusual &= is_record  # a generated motion is right at any amplitude
    if not unusual.any():
        return {}
    ends = " to ".join(dict.fromkeys(f"{factor:.3g}" for factor in (factors.min(), factors.max())))
    flag = (
        f"scale factors to the amplitudes of the grid ({study.grid.measure.words}) are outside {low:g} to {high:g}; "
        f"over all motions they are {ends}"
    )
    return {motion.name: (flag,) for motion, is_unusual in zip(motions, unusual, strict=True) if is_unusual}


def numbers_of(study: Scene, laws: Laws) -> dict[str, str]:
    """Attributes that follow from numbers of the scene, and differ along an axis of such a number."""
    notes = level_notes(study)
    rules = [said_restitution(interface.restitution.words) for interface in study.interfaces]
    return {
        "references": "; ".join(sources_of(study, [law for of_model in laws for law in of_model])),
        "stiffness": as_text(
            {
                name: [getattr(bare(law), "stiffness", None) for law in of_model]
                for name, of_model in zip(study.grid.contact_models, laws, strict=True)
                if not all(map(is_instant, of_model))
            }
        ),
        "restitution": rules[0] if len(set(rules)) == 1 else "; ".join(rules),
        "restitution_relation": study.relation,
        **({"level_notes": as_text(notes)} if notes else {}),
    }


def plugin_attributes(study: Scene) -> dict[str, str]:
    """Versions of the libraries and of the plug-ins that a scene uses, and what it has of them."""
    used = plugins_of(study)
    origins = {f"{GROUPS[plugin.group]} {plugin.name}": plugin.origin for plugin in used}
    all_versions = versions() | {plugin.distribution: plugin.version for plugin in used}
    return {"versions": as_text(all_versions), **({"plugins": as_text(origins)} if origins else {})}


def made_from(study: Scene, motions: Iterable[Motion]) -> dict[str, Any]:
    """Attributes of every dataset of a scene: the scene, its motions, and the versions of the libraries."""
    unused = unused_keys(study)
    return {
        VERSION: DATASET_VERSION,
        "scene": study.text or study.to_toml(),
        "scene_resolved": study.to_toml(),
        "overrides": as_text(list(study.overrides)),
        "rtol": study.rtol,
        "records": as_text([{**motion.record, "name": motion.name, "dt": motion.dt} for motion in motions]),
        "processing": as_text({motion.name: list(motion.processing) for motion in motions}),
        **plugin_attributes(study),
        **({"unused_keys": as_text(unused)} if unused else {}),
    }
