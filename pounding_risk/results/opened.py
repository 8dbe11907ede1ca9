"""Results of `scan` as statistics take them: a dataset with all its axes, and what its scene says of it.

`Results` has what the attributes of such a dataset say: the tables of its scene, the case of the grid that the scene
itself describes, and the amplitudes of the motions. `files.open_scan` opens, checks and makes one.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from functools import cached_property
from math import isclose, isfinite
from tomllib import TOMLDecodeError
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import DIGITS, FACTOR, LEVEL_AXIS, PEAK, USUAL_DAMPING, Level, Measure, sa_at
from pounding_risk.motions.processing.signals import LEAST_SHAKING
from pounding_risk.motions.record import recording_numbers
from pounding_risk.results import contact_notes
from pounding_risk.results.amplitudes import (
    SAME,
    Amplitudes,
    axis_words,
    check_pga,
    listed_values,
    own,
    place_of,
    quantity_of,
)
from pounding_risk.results.attributes import collapsed, flags_of, read_attribute, tables_of, unreadable
from pounding_risk.results.check import check_scene, kind_of
from pounding_risk.results.layout import amplitude_axis, axes_of_cases
from pounding_risk.results.scene_axes import at_one_place, open_axes
from pounding_risk.results.variables import UNPUSHED
from pounding_risk.units import (
    DAMPING,
    GAP,
    LINK_DAMPING,
    LINK_STIFFNESS,
    PERIOD,
    PGA,
    SCALE,
    YIELD_FORCE,
    parse,
    say,
    si,
)

if TYPE_CHECKING:
    import xarray as xr

CROWDED = 3  # recordings of its own earthquake, with itself, that the mean recording has where a note says so
WITH_CASES = ("scan", "compare", "effects", "histories")


@dataclass(frozen=True, eq=False)
class Results:
    """A dataset of `scan`, or a part of one, with the scene in its attributes.

    A part, such as that of one interface, is `Results` of its own; the text of its scene is parsed once for all parts.
    """

    dataset: xr.Dataset
    name: str = "the dataset"  # in sentences

    @cached_property
    def scene(self) -> dict[str, Any]:
        """The tables of the scene, every value stated; none where the dataset has lost them.

        Raises PoundingError where their text is damaged.
        """
        try:
            return tables_of(str(self.dataset.attrs.get("scene_resolved", "")))
        except TOMLDecodeError:
            raise unreadable("scene_resolved") from None

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on the input of the scan, and on contacts that are implausible: cases are read block by block.

        Raises PoundingError where the attributes with these notes, or with the scene, are damaged.
        """
        of_input = tuple(map(str, read_attribute(self.dataset, "notes", [])))
        return (*of_input, *self.nearest_notes, *self.event_notes, *contact_notes.of_scan(self.dataset, self.scene))

    @property
    def event_notes(self) -> tuple[str, ...]:
        """A note where many recordings are of one earthquake: bounds by recording take them to be independent."""
        events = self.dataset.variables.get("record_event")
        if events is None or events.dims != ("record",):
            return ()
        pairs = set(zip(self.recordings.tolist(), map(str, events.values), strict=True))
        counts = Counter(event for _, event in sorted(pairs) if event)
        if not counts or sum(count**2 for count in counts.values()) < CROWDED * counts.total():
            return ()
        (event, most), earthquakes = counts.most_common(1)[0], counted(len(counts), "earthquake")
        return (
            f"{counts.total()} recordings are of {earthquakes}, {most} of them of {event}: bounds take recordings to "
            "be independent, and are too narrow where those of one earthquake are alike",
        )

    @property
    def nearest_notes(self) -> tuple[str, ...]:
        """Notes on the scene's own gap and F_E where the grid has others alone, of which the nearest is taken."""
        if not self.scene.get("interface") or "gap" not in self.dataset.dims or open_axes(self.dataset):
            return ()
        interface, gaps = self.varied_interface, self.dataset["gap"].values
        gaps = self.gaps.values[:, interface] if "interface" in self.dataset.dims else gaps
        force = parse(self.scene["interface"][0].get("yield_force", "inf"), YIELD_FORCE)
        compared = {"gap": (self.scene_gap(interface), float(gaps[self.scene_place]), GAP)}
        if self.dataset.sizes.get("yield_force", 1) > 1 and np.isfinite([force, self.scene_force]).all():
            compared["yield_force"] = force, self.scene_force, YIELD_FORCE
        notes = tuple(
            f"{key}: the scene's own, {say(stated, quantity, 4)}, is not in the grid; forces, yielding and damage are "
            f"those at {say(grid_value, quantity, 4)}, the nearest there: add it to {key} in [grid]"
            for key, (stated, grid_value, quantity) in compared.items()
            if abs(stated - grid_value) > SAME * abs(stated)
        )
        own_gaps = [self.scene_gap(place) for place in range(self.dataset.sizes.get("interface", 1))]
        if np.ptp(own_gaps) > SAME * max(own_gaps) and not np.ptp(self.gaps.values, axis=1).any():
            notes += (
                f"gap: the row with the scene's own gaps, {listed_values('gap', own_gaps)}, was not run: [grid] gap "
                "sets every gap of the row; each interface is assessed in runs in which all have the same gap",
            )
        return notes

    @property
    def unused_keys(self) -> tuple[str, ...]:
        """Keys of the scene that change nothing in it, and why."""
        return tuple(map(str, read_attribute(self.dataset, "unused_keys", [])))

    @property
    def flags(self) -> dict[str, list[str]]:
        """Doubts on each record by its name, as its quality checks state them."""
        return dict(read_attribute(self.dataset, "flags", {}))

    @property
    def left_out(self) -> tuple[str, ...]:
        """Files of records that were excluded, and why."""
        return tuple(read_attribute(self.dataset, "left_out", []))

    @property
    def level_notes(self) -> dict[str, Any]:
        """Notes on the amplitudes, by interface."""
        return dict(read_attribute(self.dataset, "level_notes", {}))

    # ------------------------------------------------------------------------ parts

    @cached_property
    def interfaces(self) -> tuple[tuple[str, Results], ...]:
        """Each pair of neighbours, named "left | right", and its part, without the dimension of interfaces.

        ``gap`` is the interface's own. Where the grid varies another's gap, its own is one: beside that gap of the
        other which is nearest to the scene's. So is ``yield_force`` of a grid of one: that of its floors, of columns
        where floors meet columns alone.
        """
        names = map(str, self.dataset["interface"].values)
        return tuple((name, replace(self, dataset=self._interface(index))) for index, name in enumerate(names))

    def _interface(self, index: int) -> xr.Dataset:
        dataset, places = self.dataset, {"interface": index, "building": slice(index, index + 2)}
        if "contact_point" in dataset.dims:
            places["contact_point"] = np.flatnonzero(dataset["contact_point_interface"].values == index)
        gaps = self.gaps.isel(interface=index)
        if gaps.size > 1 and np.ptp(gaps.values) == 0.0:
            places["gap"] = slice(*(self.scene_place + end for end in (0, 1)))
            gaps = gaps.isel(gap=places["gap"])
        part = dataset.isel(places).assign_coords(gap=("gap", gaps.values, dataset["gap"].attrs))
        names = "yield_force", "contact_point_yield_force"
        if not set(names) <= set(part.coords) or part["yield_force"].shape != (1,):
            return part
        if not set(part[names[1]].dims) <= {"yield_force", "contact_point"}:  # along an axis each place has its own
            return part
        return part.assign_coords(yield_force=("yield_force", [_own_force(part)], part["yield_force"].attrs))

    def read_gap(self, gap: float | str | None) -> float | None:
        """An assessed gap [m]; raises PoundingError for one that is no gap, or that bumpers do not fit into."""
        if gap is None:
            return None
        width = si(gap, GAP._replace(open_high=True), "gap")
        longest = float(np.max(self.dataset.coords.get("interface_bumper", 0.0)))
        if longest > width:
            raise PoundingError(
                f"gap: bumpers of {say(longest, GAP)} do not fit into a gap of {say(width, GAP)}; write a wider gap, "
                "which is that between the faces"
            )
        return width

    def at_level(self, level: int | None = None) -> Results:
        """The part at one of the amplitudes, by default the scene's own; all of it where there is no axis of them."""
        axis, dataset = amplitude_axis(self.dataset), self.dataset
        place = self.scene_level if level is None else level
        return replace(self, dataset=dataset.isel({axis: place})) if axis in dataset.dims else self

    # ------------------------------------------------------------------------ runs and records

    @property
    def run_counts(self) -> dict[str, int]:
        """Numbers of cases: all, simulated, failed, recomputed at a tighter tolerance, and sensitive among these."""
        dataset, status = self.dataset, self.dataset["status"]
        (complete,) = (code for code, word in flags_of(status).items() if word == "complete")
        flags = dataset["sensitive"].values if "sensitive" in dataset else np.full(1, -1)
        return {
            "cases": int(status.size),
            "simulated": int((dataset["simulated"].values == 1).sum()) if "simulated" in dataset else int(status.size),
            "failed": int((status.values != complete).sum()) - self.unpushed,
            "checked": int((flags >= 0).sum()),
            "sensitive": int((flags == 1).sum()),
        }

    @property
    def unpushed(self) -> int:
        """Number of cases that were not run, as a building whose motion is known would have to be pushed."""
        return int((self.dataset["status"].values == UNPUSHED).sum())

    @property
    def fallen(self) -> int:
        """Number of cases in which a storey collapses."""
        return int(collapsed(self.dataset).sum())

    @property
    def is_shaking(self) -> NDArray[np.bool_]:
        """Whether each record holds a motion; datasets of older versions may have records that do not."""
        if "record_pga" not in self.dataset.coords:
            return np.ones(self.dataset.sizes["record"], dtype=bool)
        return np.asarray(self.dataset["record_pga"].values >= LEAST_SHAKING)

    @property
    def recordings(self) -> NDArray[np.int64]:
        """The number of each record's recording; one are those that share an aftershock, or every bit of the motion."""
        names = list(map(str, self.dataset["record"].values))
        facts = {record.get("name"): record for record in read_attribute(self.dataset, "records", [])}
        digests = read_attribute(self.dataset, "motions_sha256", {})
        of_records = [facts.get(name, {}) for name in names]
        return recording_numbers(of_records, names, [str(digests.get(name, name)) for name in names])

    @property
    def record_doubts(self) -> tuple[str, ...]:
        """A sentence for each record that is a copy of another, as `scan` found it, is here twice, or has no motion."""
        digests = read_attribute(self.dataset, "motions_sha256", {})
        names = list(map(str, self.dataset["record"].values))
        first_names: dict[str, str] = {}
        originals = [(name, first_names.setdefault(digests.get(name, name), name)) for name in names]
        copies = [
            f"{name} holds the same motion as {original}: it counts twice in the shares, scan again"
            for name, original in originals
            if original != name
        ]
        dead = [name for name, shakes in zip(names, self.is_shaking, strict=True) if not shakes]
        notes = [f"{name} holds no motion: it counts against the verdict, scan again without it" for name in dead]
        return (*read_attribute(self.dataset, "copies", []), *copies, *notes)

    # ------------------------------------------------------------------------ the scene's own case

    @property
    def gaps(self) -> xr.DataArray:
        """Gaps (gap, interface) [m] of a row: a grid may vary the gap of one interface only.

        Of an interface whose gap differs from sample to sample it is the one that the scene states; that of the first
        sample where the text of the scene is lost.
        """
        if "interface_gap" not in self.dataset.variables:
            gaps = self.dataset["gap"].expand_dims(interface=self.dataset["interface"].values)
            return gaps.transpose("gap", "interface")
        of_places = self.dataset["interface_gap"].broadcast_like(self.dataset["gap"]).transpose("gap", "interface", ...)
        along = of_places.dims[2:]
        if not along:
            return of_places
        first_gaps = of_places.isel(dict.fromkeys(along, 0)).reset_coords(drop=True)  # without the gaps of one sample
        if not self.scene.get("interface"):
            return first_gaps
        stated_gaps = [self._stated_gap(index) for index in range(first_gaps.sizes["interface"])]
        return first_gaps.copy(data=np.where((of_places == first_gaps).all(along), first_gaps, stated_gaps))

    @property
    def varied_interface(self) -> int:
        """The first interface whose gap the grid varies; the first of all where it varies none."""
        if "interface" not in self.dataset.dims or "gap" not in self.dataset.dims:
            return 0
        return int((np.ptp(self.gaps.values, axis=0) > 0.0).argmax())

    def scene_gap(self, interface: int) -> float:
        """The scene's own gap [m] at an interface, or the one that a selection of the grid's has left there.

        `[[interface]]` stands once for all or once for each.
        """
        scene_gap = self._stated_gap(interface)
        grid_gaps = self.scene.get("grid", {}).get("gap", ())
        if len(grid_gaps) < 2 or "gap" not in self.dataset.dims or self.dataset.sizes["gap"] > 1:
            return scene_gap
        return float(self.gaps.values[0, interface] if "interface" in self.dataset.dims else self.dataset["gap"][0])

    def _stated_gap(self, interface: int) -> float:
        """What the table of an interface says of its gap [m]."""
        tables = self.scene["interface"]
        return parse(tables[min(interface, len(tables) - 1)]["gap"], GAP)

    def has_link(self, interface: int) -> bool:
        """True where a spring or a damper joins the two buildings of an interface."""
        return bool(self.link_words(interface))

    def link_words(self, interface: int) -> str:
        """Stiffness and damping of what joins the two buildings of an interface; "" of nothing."""
        tables = self.scene.get("interface") or [{}]
        table = tables[min(interface, len(tables) - 1)]
        keys = {"link_stiffness": LINK_STIFFNESS, "link_damping": LINK_DAMPING}
        values = {key: parse(table[key], quantity) for key, quantity in keys.items() if key in table}
        return ", ".join(f"{key} = {say(value, keys[key])}" for key, value in values.items() if value > 0.0)

    @property
    def scene_place(self) -> int:
        """Index of the gap of the grid that is nearest to the scene's own, at the interface whose gap varies."""
        interface = self.varied_interface
        gaps = self.gaps.values[:, interface] if "interface" in self.dataset.dims else self.dataset["gap"].values
        return int(np.abs(gaps - self.scene_gap(interface)).argmin())

    @property
    def scene_force(self) -> float:
        """The yield force of the grid that is nearest to the scene's own [N]; inf where that never yields."""
        forces = self.dataset["yield_force"].values
        stated_force = parse(self.scene["interface"][0].get("yield_force", "inf"), YIELD_FORCE)
        return float(forces.max() if np.isinf(stated_force) else forces[np.abs(forces - stated_force).argmin()])

    @property
    def scene_model(self) -> str:
        """The scene's own contact model where the grid has it, or the grid's first."""
        stated_model = str(self.scene["interface"][0].get("contact_model", ""))
        models = list(map(str, self.dataset["contact_model"].values))
        return stated_model if stated_model in models else models[0]

    @property
    def scene_amplitude(self) -> float | None:
        """The scene's own peak ground acceleration [m/s²] where the grid has it; None where it has not.

        So it is where the grid has levels of another measure.
        """
        stated_pga = self.scene.get("records", {}).get("pga")
        if stated_pga is None or "pga" not in self.dataset.coords:
            return None
        scene_pga = parse(stated_pga, PGA)
        amplitudes = np.atleast_1d(self.dataset["pga"].values)
        return next((float(pga) for pga in amplitudes if abs(pga - scene_pga) <= SAME * scene_pga), None)

    @property
    def scene_level(self) -> int:
        """Index of the amplitude that is assessed unless an option names one: the scene's own, or the largest."""
        axis = amplitude_axis(self.dataset)
        if axis not in self.dataset.coords:
            return 0
        amplitudes, scene_pga = np.atleast_1d(self.dataset[axis].values), self.scene_amplitude
        return int(np.argmax(amplitudes) if scene_pga is None else np.argmin(np.abs(amplitudes - scene_pga)))

    @property
    def scene_case(self) -> dict[str, int]:
        """Index of the scene's own case along each axis, or of the nearest value where the grid does not have it.

        Empty for a dataset without the text of its scene.
        """
        if not self.scene.get("interface"):
            return {}
        axis, dataset = amplitude_axis(self.dataset), self.dataset
        index: dict[str, int] = {}
        if "gap" in dataset.dims:
            index["gap"] = self.scene_place
        if "yield_force" in dataset.dims:
            index["yield_force"] = int(np.flatnonzero(dataset["yield_force"].values == self.scene_force)[0])
        if "contact_model" in dataset.dims:
            index["contact_model"] = list(map(str, dataset["contact_model"].values)).index(self.scene_model)
        if axis in dataset.dims:
            index[axis] = self.scene_level
        return index

    @property
    def scene_contact(self) -> dict[str, int]:
        """`scene_case` along the axes of contact models and yield forces alone."""
        return {axis: place for axis, place in self.scene_case.items() if axis in ("contact_model", "yield_force")}

    @property
    def scene_values(self) -> dict[str, Any]:
        """The scene's own gap [m], yield force [N], contact model and amplitude [m/s²], as far as its text has them."""
        if not self.scene.get("interface"):
            return {}
        table, pga = self.scene["interface"][0], self.scene.get("records", {}).get("pga")
        values = {
            "gap": self.scene_gap(self.varied_interface),
            "yield_force": parse(table.get("yield_force", "inf"), YIELD_FORCE),
            "contact_model": table.get("contact_model"),
            "pga": None if pga is None else parse(pga, PGA),
        }
        return {axis: value for axis, value in values.items() if value is not None}

    # ------------------------------------------------------------------------ amplitudes of the motions

    @property
    def measure(self) -> Measure:
        """The measure of the amplitudes."""
        if LEVEL_AXIS not in self.dataset.variables:
            return PEAK
        attrs = self.dataset[LEVEL_AXIS].attrs
        periods = tuple(float(period) for period in np.atleast_1d(attrs.get("periods", ())))
        return Measure(str(attrs["measure"]), periods, float(attrs.get("damping", USUAL_DAMPING)))

    @property
    def amplitudes(self) -> Amplitudes:
        """The amplitudes: one that was selected or scanned alone counts too."""
        axis = amplitude_axis(self.dataset)
        if axis not in self.dataset.coords:
            return Amplitudes(axis, PEAK, (None,))
        return Amplitudes(axis, self.measure, tuple(map(float, np.atleast_1d(self.dataset[axis].values))))

    def level(self, pga: float | str | None = None, intensity_level: float | str | None = None) -> int | None:
        """Index of the amplitude that a call names by one of its two options; None where it names none.

        ``intensity_level`` is a value of whatever measure the dataset has, PGA too. Raises PoundingError where both
        are given, for ``pga`` of a dataset of another measure, and for a value that the dataset has not.
        """
        amplitudes = self.amplitudes
        if pga is not None and intensity_level is not None:
            raise PoundingError("pga and intensity_level both name the amplitude; give one of them")
        if pga is not None:
            check_pga(amplitudes)
        return amplitudes.place(pga if pga is not None else intensity_level)

    def amplitude_words(self, level: float | None = None) -> str:
        """The amplitude in words that follow "motions": "as recorded", "at Sa(0.62 s) = 0.7 g", "times 1.5".

        ``level`` is one amplitude of a grid that has several [SI]; all of them by default.
        """
        amplitudes = self.amplitudes
        measure, values = amplitudes.measure, [amplitude for amplitude in amplitudes.values if amplitude is not None]
        levels = [amplitude for amplitude in (values if level is None else [level]) if isfinite(amplitude)]
        span = " to ".join(dict.fromkeys(amplitudes.words(end) for end in (min(levels), max(levels)))) if levels else ""
        if span and measure.name != FACTOR:
            return f"at PGA {span}" if measure == PEAK else f"at {measure.words} = {span}"
        records = self.scene.get("records", {})
        factor = f"times {parse(records['scale'], SCALE):.{DIGITS}g}" if records.get("scale") is not None else ""
        factor = f"times {span}" if span else factor
        return " ".join(filter(None, (_scaling_words(records), factor))) or "as recorded"

    @property
    def scaled_to(self) -> Level | None:
        """The spectral acceleration that every motion has; None where motions are not scaled to one."""
        records = self.scene.get("records", {})
        if "pga" in self.dataset.coords or "sa" not in records:
            return None
        level = _level_of(records["sa"])
        return level._replace(value=level.value * parse(records.get("scale", 1.0), SCALE))

    @property
    def usual_intensity(self) -> str:
        """The intensity that the motions are scaled to: the default intensity of fragilities.

        It is the measure of the levels where they are no factors; Sa at a period where the scene scales to it, or to
        the ensemble's median of it and the dataset has such a spectrum; PGA elsewhere.
        """
        if self.measure.name != FACTOR and self.measure != PEAK:
            return self.measure.intensity
        if self.scaled_to is not None:
            return self.scaled_to.measure.intensity
        table = self.scene.get("records", {}).get("to_median")
        if not isinstance(table, dict) or "pga" in self.dataset.coords:
            return "pga"
        measure = _level_of(table).measure
        return measure.intensity if self.has_spectrum_at(measure) else "pga"

    @property
    def spectral_range(self) -> tuple[float, float] | None:
        """The range of periods [s] in which the dataset has Sa of every record; None where there is none."""
        if "record_spectral_acceleration" not in self.dataset:
            return None
        spectra = self.dataset["record_spectral_acceleration"].transpose("record", "period").values
        periods = self.dataset["period"].values[(spectra > 0.0).all(axis=0)]
        return (float(periods[0]), float(periods[-1])) if periods.size else None

    def has_spectrum_at(self, intensity: Measure) -> bool:
        """True where the spectra of the dataset, which have 5 % damping, include this period and damping."""
        span = self.spectral_range
        has_damping = isclose(intensity.damping, USUAL_DAMPING, rel_tol=SAME)
        return span is not None and has_damping and span[0] <= intensity.period <= span[1]

    # ------------------------------------------------------------------------ values along axes

    def axis_name(self, axis: str) -> str:
        """An axis of cases as sentences and readers of values take it: that of levels by the word of its measure."""
        return self.measure.intensity if axis == LEVEL_AXIS else axis

    def values_along(self, axis: str) -> tuple[Any, ...]:
        """The values of an axis of cases, one where it was selected: floats of a quantity, else names."""
        kind = str if quantity_of(self.axis_name(axis)) is None else float
        return tuple(map(kind, np.atleast_1d(self.dataset[axis].values)))

    def place(self, axis: str, requested: Any) -> int:
        """Index along an axis of a value as a user writes it, or of the scene's own where it is None.

        Of records and polarities, which a scene has several of, it is then the first. Raises PoundingError for a value
        that the grid has not.
        """
        name = self.axis_name(axis)
        if axis not in self.dataset.coords:
            return 0 if requested is None else place_of(name, (None,), requested)
        if self.dataset[axis].dims not in ((), (axis,)):
            if requested is None:
                return 0
            raise PoundingError(f"{axis_words(name)}: of each contact model there is one case; select by contact_model")
        labels = self.values_along(axis)
        if requested is not None:
            return place_of(name, labels, requested)
        if len(labels) == 1 or axis in ("record", "polarity"):
            return 0
        scene_values = self.scene_values
        if axis not in scene_values:
            labels_text = listed_values(name, labels)
            option = "intensity_level" if axis == LEVEL_AXIS else axis  # intensity is that of fragilities
            raise PoundingError(f"{option}: the scene has none of its own, and the grid has {labels_text}; name one")
        try:
            return place_of(name, labels, scene_values[axis])
        except PoundingError as error:
            raise PoundingError(f"{axis}: none is named, and the scene's own is not there: {error}; name one") from None


def _scaling_words(records: dict[str, Any]) -> str:
    """What a table [records] scales the motions to; "" where they are not scaled."""
    if "manifest" in records:
        return f"with the factors of {records['manifest']}"
    if "to_median" in records:
        measure = records["to_median"]
        words = _level_of(measure).measure.words if isinstance(measure, dict) else measure.upper()
        return f"at the ensemble's median {words}"
    if "sa" in records:
        return f"at {_level_of(records['sa']).words}"
    return f"at PGA {own(parse(records['pga'], PGA), PGA)}" if "pga" in records else ""


def _own_force(interface: xr.Dataset) -> float:
    """F_E of the contacts of one interface [N], which its points have, in a grid of one yield force.

    That of its lowest floors, where a floor that rotates has two points of a half each; of columns the smallest.
    """
    floors, columns = yield_forces(interface)
    return floors[0] if floors else min(columns)


def yield_forces(case: xr.Dataset) -> tuple[list[float], list[float]]:
    """Yield forces [N] of a case: of floors that meet, in the order of the contact points, and of struck columns.

    A floor that rotates has two points of a half each.
    """
    if "contact_point_yield_force" not in case.variables:
        return [float(case["yield_force"])], []
    forces = np.atleast_1d(case["contact_point_yield_force"].values.squeeze()).tolist()
    names = ("kind", "interface", "left_floor", "right_floor")
    labels = (np.broadcast_to(case[f"contact_point_{name}"].values, len(forces)) for name in names)
    floors: dict[tuple[float, ...], float] = {}
    columns = []
    for force, kind, *place in zip(forces, *labels, strict=True):
        if kind == "column":
            columns.append(force)
        else:
            floors[tuple(place)] = floors.get(tuple(place), 0.0) + force
    return list(floors.values()), columns


def _level_of(table: dict[str, Any]) -> Level:
    """A table {value, period, damping} of a resolved scene, the value 0 where it has none."""
    measure = sa_at(parse(table["period"], PERIOD), parse(table.get("damping", USUAL_DAMPING), DAMPING))
    return Level(measure, parse(table["value"], PGA) if "value" in table else 0.0)


def one_case(
    results: xr.Dataset,
    *,
    record: str | None = None,
    polarity: str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
    contact_model: str | None = None,
    gap: float | str | None = None,
    yield_force: float | str | None = None,
) -> xr.Dataset:
    """Select one case of the grid by its values, which must be values of the grid.

    Of what is left out the scene's own value is taken, and of records and polarities the first, as in `simulate`. The
    values stay in the dataset as coordinates.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`, `compare`, `effects` or `histories`.
    record : str, optional
        Name of a record.
    polarity : str, optional
        Name of a polarity.
    pga : float or str, optional
        Amplitude of the grid [m/s2, or text with a unit].
    intensity_level : float or str, optional
        Amplitude of the grid in its own measure [SI, or text with a unit], where that may be another than PGA.
    contact_model : str, optional
        Name of a contact model.
    gap : float or str, optional
        Gap [m, or text with a unit].
    yield_force : float or str, optional
        Yield force F_E [N, or text with a unit].

    Returns
    -------
    xarray.Dataset
        The part of the dataset that belongs to the case, with all its attributes.

    Raises
    ------
    PoundingError
        For a value that the grid has not, with those that it has; for several values along an axis of another number
        of the scene; where several values are left and none is the
        scene's own; and for a dataset without a grid.
    """
    results = at_one_place(results)
    kind, opened = kind_of(results), Results(results)
    if kind not in WITH_CASES:
        why = "is one case as it is" if kind == "simulate" else "has no grid of cases"
        raise PoundingError(f"the dataset of {kind or 'another program'} {why}; a case is selected from that of a scan")
    if pga is not None and (intensity_level is not None or opened.measure != PEAK):
        raise PoundingError(f"pga: the amplitude is named by intensity_level, of {opened.measure.words}; leave pga out")
    check_scene(results)
    labels = (record, polarity, intensity_level if pga is None else pga, contact_model, gap, yield_force)
    cell = {axis: opened.place(axis, label) for axis, label in zip(axes_of_cases(results), labels, strict=True)}
    return results.isel({axis: place for axis, place in cell.items() if axis in results.dims})
