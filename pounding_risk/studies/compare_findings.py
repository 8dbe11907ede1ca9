"""Results of a comparison of contact models: ratios to a baseline, ranks, conclusions that flip, and the finding.

A case is one record, polarity, amplitude, gap and yield force. Ratios are over the cases in which the baseline has
contact: elsewhere there is nothing to compare. A case in which either run failed is left out and counted nowhere.

All of it is by interface: an output of an interface is compared over the cases with contact there, one of a building
over those with contact at either of its interfaces. Tables have the dimension `interface` where the dataset has it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.words import nearest, words_of
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.variables import described

Array = NDArray[np.float64]

MOTIONS = ("record", "polarity", PGA_AXIS, LEVEL_AXIS)  # a dataset has one of the two axes of amplitudes at most
CASES = (*MOTIONS, "gap", "yield_force")
RUN_OUTPUTS = words_of("peak_relative_displacement", "peak_contact_force", "impact_count", "impulse")
SIDE_OUTPUTS = words_of("peak_displacement", "peak_floor_acceleration")
REACH = "peak relative displacement"
FIRST_TWO = tuple(RUN_OUTPUTS.values())[:2]  # that a line of a table has room for
NOTABLE = 0.10  # a peak that differs by more than this share leads to another answer
OFTEN = 0.05  # and a conclusion that flips in more than this share of the cases matters
LOW, MIDDLE, HIGH = 16.0, 50.0, 84.0  # percentiles: one standard deviation to either side, were it normal
CONCLUSIONS = {
    "contact": "contact or none",
    "yield exceedance": "the uncapped force reaches a finite F_E",
    "displacement": f"peak relative displacement differs by over {100 * NOTABLE:.0f} %",
    "gap adequacy": "smallest gap of the grid without contact, by motion",
}
FLIPS = {
    "displacement": f"{REACH} is off by over {100 * NOTABLE:.0f} %",
    "yield exceedance": "yielding or not flips",
    "gap adequacy": "the gap needed differs",
}
OPEN_GAP = (
    "smallest gap of the grid without contact; NaN where every gap has contact, or where the grid varies another one"
)
APART = " | "  # between the units of a stiffness that has another one at each interface
AT_SOME = -1  # whether the yield force acts, of a model that stands for another one at each interface
NUMBERED = 2  # outputs that the sentence gives numbers for
FEWEST_TO_RANK = 3  # motions
FEWEST = 5  # cases with contact: the range of fewer is stated with their number
# What a comparison may find: that the model matters, that yielding does, neither; or that there is nothing to compare.
MODEL, YIELDING, HARDLY, UNTOUCHED, ALONE = "model", "yielding", "hardly", "no contact", "no other law"
Moved = tuple[str, str, float, float]  # (output, law that goes furthest, its 16th and 84th percentile)


def interface_names(dataset: xr.Dataset) -> list[str]:
    """The interfaces of a dataset, left to right; a dataset without the dimension is of one."""
    if "interface" in dataset.dims:
        return [str(name) for name in dataset["interface"].values]
    return [" | ".join(str(name) for name in dataset["building"].values[:2])]


def at_interface(dataset: xr.Dataset, index: int) -> xr.Dataset:
    """The dataset of interface ``index`` alone, from 0, with all buildings; without the dimension `interface`."""
    return dataset.isel(interface=index, drop=True) if "interface" in dataset.dims else dataset


def of_interface(dataset: xr.Dataset, index: int) -> xr.Dataset:
    """What a comparison says of interface ``index``: its own outputs and those of its two buildings, under one name."""
    names = interface_names(dataset)
    buildings = [str(name) for name in dataset["building"].values[index : index + 2]]
    names_of_outputs = {_label(words, names[index], names): words for words in RUN_OUTPUTS.values()}
    names_of_outputs |= {
        (name := f"{words}, {building}"): name for words in SIDE_OUTPUTS.values() for building in buildings
    }
    pair = at_interface(dataset, index)
    if "interface_contact_model" in dataset:
        pair["interface_contact_model"] = str(dataset["interface_contact_model"].values[index])
    if "stiffness_unit" in pair:
        units = [str(unit).split(APART) for unit in pair["stiffness_unit"].values]
        pair["stiffness_unit"] = "contact_model", [unit[index] if len(unit) > 1 else unit[0] for unit in units]
    pair = pair.sel(output=[name for name in map(str, dataset["output"].values) if name in names_of_outputs])
    return pair.assign_coords(output=[names_of_outputs[str(name)] for name in pair["output"].values])


def _label(words: str, interface: str, interfaces: list[str]) -> str:
    """An output's words with its interface, where there are several."""
    return f"{words}, {interface}" if len(interfaces) > 1 else words


def outputs_of(dataset: xr.Dataset, baseline: str) -> dict[str, tuple[xr.DataArray, NDArray[np.bool_]]]:
    """The outputs that are compared, by their words, each with the cases over which it is.

    NaN where a run failed or a law does not define one. Under a model whose velocities jump the acceleration is that
    between the jumps, which have none that is finite: there is nothing to compare. So it is with the force of those
    that have none in the reference impact either. A building that touches neither neighbour moves as it does alone,
    whatever the rest of the row does.
    """
    interfaces = interface_names(dataset)
    sides = [at_interface(dataset, index) for index in range(len(interfaces))]
    touched = [touching(at_side, baseline) for at_side in sides]
    outputs = {
        _label(words, interface, interfaces): (at_side[name], cases)
        for interface, at_side, cases in zip(interfaces, sides, touched, strict=True)
        for name, words in RUN_OUTPUTS.items()
    }
    for name, words in SIDE_OUTPUTS.items():
        for side, building in enumerate(dataset["building"].values):
            cases = np.any(touched[max(side - 1, 0) : side + 1], axis=0)
            outputs[f"{words}, {building}"] = dataset[name].isel(building=side, drop=True), cases
    if "stiffness_unit" in dataset:
        jumps = dataset["stiffness_unit"] == ""
        undefined = {"peak contact force": jumps & ~with_terms_of_its_own(dataset), "peak floor acceleration": jumps}
        for words, (output, cases) in outputs.items():
            for start, is_undefined in undefined.items():
                if words.startswith(start):
                    outputs[words] = output.where(~is_undefined), cases
    # Counts are stored as -1 where a run failed.
    return {words: (output.where(output >= 0.0), cases) for words, (output, cases) in outputs.items()}


def by_case(output: xr.DataArray) -> Array:
    """Values of a variable as an array (laws, cases)."""
    axes = [axis for axis in CASES if axis in output.dims]
    table = output.transpose("contact_model", *axes).values
    return table.reshape(len(table), -1).astype(float)


def place_of(dataset: xr.Dataset, law: str) -> int:
    """Index of a law along ``contact_model``."""
    return list(map(str, dataset["contact_model"].values)).index(law)


def touching(dataset: xr.Dataset, baseline: str) -> NDArray[np.bool_]:
    """True for each case in which the baseline has contact; of the dataset of one interface."""
    return by_case(dataset["impact_count"])[place_of(dataset, baseline)] > 0.0


def ratios(output: xr.DataArray, baseline: int, cases: NDArray[np.bool_]) -> Array:
    """(laws, cases): each law's value over the baseline's; NaN outside ``cases`` and where either is not defined."""
    table = by_case(output)
    divisor = np.where(cases & (table[baseline] > 0.0), table[baseline], nan)
    return np.asarray(table / divisor)


def rank_agreement(output: xr.DataArray, baseline: int, cases: NDArray[np.bool_]) -> Array:
    """(laws, 2): Spearman's correlation with the baseline of how a law ranks the motions: median and lowest.

    The motions are ranked at each gap and yield force, where three or more of them lead to contact; NaN where
    a law or the baseline has the same value for all of them, for nothing is ranked then.
    """
    motions = [axis for axis in MOTIONS if axis in output.dims]
    ordered = output.transpose("contact_model", *motions, "gap", "yield_force").values
    shape = (len(ordered), -1, output.sizes["gap"] * output.sizes["yield_force"])
    table, used = ordered.reshape(shape), cases.reshape(shape[1:])
    agreements = []
    for law in spearman(table, np.broadcast_to(table[baseline], table.shape), used):
        defined = law[~np.isnan(law)]
        agreements.append((np.median(defined), defined.min()) if defined.size else (nan, nan))
    return np.array(agreements)


def spearman(x: Array, y: Array, used: NDArray[np.bool_]) -> Array:
    """Correlation of the ranks of two variables along the second axis from the end, over the cases that are used.

    NaN for fewer than `FEWEST_TO_RANK` defined ones, and where either is constant. As `scipy.stats.spearmanr` to the
    bit, for all columns at once: sums of half-integers are exact in any order.
    """
    from scipy.stats import rankdata

    is_used = used & ~np.isnan(x) & ~np.isnan(y)
    count = is_used.sum(axis=-2, keepdims=True)
    ranks = (rankdata(np.where(is_used, outputs, nan), axis=-2, nan_policy="omit") for outputs in (x, y))
    first, second = (np.where(is_used, rank - 0.5 * (count + 1), 0.0) for rank in ranks)
    count = count[..., 0, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = 1.0 / (count - 1)
        deviations = (np.sqrt((outputs * outputs).sum(axis=-2) * share) for outputs in (second, first))
        correlation = (first * second).sum(axis=-2) * share
        for deviation in deviations:
            correlation = correlation / deviation
    return np.where(count < FEWEST_TO_RANK, nan, np.clip(correlation, -1.0, 1.0))


def is_varied(dataset: xr.Dataset) -> bool:
    """Whether the grid's gap is that of this interface; of the dataset of one interface."""
    return "interface_gap" not in dataset or bool((dataset["interface_gap"] == dataset["gap"]).all())


def gap_without_contact(dataset: xr.Dataset) -> xr.DataArray:
    """The smallest gap of the grid without contact at any yield force, by law and motion [m]; NaN where none is.

    Of the dataset of one interface; NaN where the grid varies the gap of another.
    """
    open_ = (dataset["impact_count"] == 0).all("yield_force")
    return dataset["gap"].where(open_ & is_varied(dataset)).min("gap")


def can_yield(dataset: xr.Dataset, index: int = 0) -> xr.DataArray:
    """True for the yield forces of the grid at which a contact point of interface ``index`` has a finite one."""
    if "contact_point_yield_force" not in dataset.coords:
        return dataset["yield_force"] < np.inf
    at_points = dataset["contact_point_yield_force"] < np.inf
    return at_points.isel(contact_point=dataset["contact_point_interface"].values == index).any("contact_point")


def flips(dataset: xr.Dataset, baseline: str, index: int = 0) -> dict[str, tuple[Array, Array]]:
    """By conclusion of `CONCLUSIONS`: in how many cases each law disagrees with the baseline, and of how many.

    At interface ``index``. Contact is judged in every case; the yield exceedance where F_E is finite and the
    displacement, both where the baseline has contact; the gap once a motion, where the grid varies this interface's.
    """
    strengths, dataset = can_yield(dataset, index), at_interface(dataset, index)
    base, cases = place_of(dataset, baseline), touching(dataset, baseline)
    count, exceeds = by_case(dataset["impact_count"]), by_case(dataset["yield_exceedance"])
    can_reach = by_case(strengths.broadcast_like(dataset["impact_count"]))[base] > 0.0
    ratio = ratios(dataset["peak_relative_displacement"], base, cases)
    closed = by_case(gap_without_contact(dataset).fillna(np.inf))
    is_run = by_case((dataset["impact_count"] >= 0).any(["gap", "yield_force"])) > 0.0
    varied = is_run & is_run[base] & is_varied(dataset)
    is_known = (count >= 0.0) & (count[base] >= 0.0)
    yields = (exceeds >= 0.0) & (exceeds[base] >= 0.0) & cases & can_reach
    by_conclusion = {
        "contact": (is_known & ((count > 0.0) != (count[base] > 0.0)), is_known),
        "yield exceedance": (yields & (exceeds != exceeds[base]), yields),
        "displacement": (np.abs(ratio - 1.0) > NOTABLE, ~np.isnan(ratio)),
        "gap adequacy": (closed != closed[base], varied),
    }
    return {name: (differs.sum(axis=1), judged.sum(axis=1)) for name, (differs, judged) in by_conclusion.items()}


def typical_case(dataset: xr.Dataset, baseline: str) -> dict[str, int]:
    """Place of the case in which the laws' peak relative displacements differ as much as in the median case.

    Of the dataset of one interface. Largest over smallest, among the cases in which the baseline has contact; the first
    case where none has.
    """
    displacements = dataset["peak_relative_displacement"]
    axes = [axis for axis in CASES if axis in displacements.dims]
    shape = [displacements.sizes[axis] for axis in axes]
    table = by_case(displacements)
    used = np.flatnonzero(touching(dataset, baseline) & ~np.isnan(table).any(axis=0))
    case = 0
    if used.size:
        width = table[:, used].max(axis=0) / table[:, used].min(axis=0)
        case = int(used[np.argsort(width, kind="stable")[(used.size - 1) // 2]])
    return dict(zip(axes, map(int, np.unravel_index(case, shape)), strict=True))


def _anywhere(output: xr.DataArray) -> NDArray[np.bool_]:
    """By law, whether a value is defined at any interface."""
    return output.notnull().any([dim for dim in output.dims if dim != "contact_model"]).values


def with_terms_of_its_own(dataset: xr.Dataset) -> NDArray[np.bool_]:
    """True for a law that has a force but no stiffness: neither its e nor its force can be made equal to another's."""
    if "stiffness_unit" not in dataset:
        return np.zeros(dataset.sizes["contact_model"], dtype=bool)
    return (dataset["stiffness_unit"].values == "") & _anywhere(dataset["reference_peak_force"])


def comparable_laws(dataset: xr.Dataset) -> list[str]:
    """The laws that the sentence is about: those that dissipate as the baseline does, or not, as it does not.

    An elastic law cannot be given the restitution of a damped one: the two are not on equal terms. Nor is one whose
    restitution is its own, or one `with_terms_of_its_own`.
    """
    baseline = str(dataset.attrs["baseline"])
    base, damped = place_of(dataset, baseline), dataset["dissipates"].values
    is_alike = (damped == damped[base]) & ~with_terms_of_its_own(dataset)
    if "reference_restitution_asked" in dataset:
        has_relation = _anywhere(dataset["reference_restitution_asked"])
        is_alike &= has_relation == has_relation[base]
    names = [str(name) for name, is_same in zip(dataset["contact_model"].values, is_alike, strict=True) if is_same]
    return [name for name in names if name != baseline]


class Verdict(NamedTuple):
    """What the choice of the contact model changes in one comparison, of which `finding` makes a sentence."""

    kind: str  # one of MODEL, YIELDING, HARDLY, UNTOUCHED and ALONE
    names: list[str]  # laws that it is about
    alike: list[str] = []  # noqa: RUF012 - those of them that yield as the baseline does, or not, as it does not
    moved: list[Moved] = []  # noqa: RUF012 - outputs that these move, widest first
    moved_by_yielding: list[Moved] = []  # noqa: RUF012 - outputs that the other laws move
    shares: dict[str, Array] = {}  # noqa: RUF012 - `flip_share` of each conclusion


def verdict(dataset: xr.Dataset) -> Verdict:
    """Does the choice of the contact model matter for these outputs and conclusions?

    It does where, of some law that yields as the baseline does, or not, as it does not, the 16-84 % range of an
    output's ratio leaves 1 ± 10 %, or a conclusion flips in more than 5 % of the cases. What moves under the other laws
    alone is the effect of yielding. Where no yield force is finite nothing yields, and all laws are alike; so they are
    beside a baseline that yields at some interfaces, where which model stands decides it.
    """
    names, baseline = comparable_laws(dataset), str(dataset.attrs["baseline"])
    if not int(dataset["judged"].sel(conclusion="displacement", contact_model=baseline).sum()):
        return Verdict(UNTOUCHED, names)
    if not names:
        return Verdict(ALONE, names)
    capped = dict(zip(map(str, dataset["contact_model"].values), dataset["capped"].values, strict=True))
    never_yields = not any(can_yield(dataset, index).any() for index in range(len(interface_names(dataset))))
    all_alike = never_yields or capped[baseline] == AT_SOME
    alike = [name for name in names if all_alike or capped[name] == capped[baseline]]
    rest = [name for name in names if name not in alike]
    moved, moved_by_yielding = _moved(dataset, alike), _moved(dataset, rest)
    by_model, by_yielding = bool(moved) or _often(dataset, alike), bool(moved_by_yielding) or _often(dataset, rest)
    kind = MODEL if by_model else YIELDING if by_yielding else HARDLY
    shares = {conclusion: flip_share(dataset, conclusion, names) for conclusion in CONCLUSIONS}
    return Verdict(kind, names, alike, moved, moved_by_yielding, shares)


def _moved(dataset: xr.Dataset, names: list[str]) -> list[Moved]:
    """(output, law that goes furthest, its 16th and 84th percentile) where that range leaves 1 ± 10 %, widest first."""
    ranges = [(str(output), *furthest(dataset, str(output), names)) for output in dataset["output"].values if names]
    wide = [moved for moved in ranges if reach(*moved[2:]) > 1.0 + NOTABLE]
    return sorted(wide, key=lambda moved: -reach(*moved[2:]))


def _often(dataset: xr.Dataset, names: list[str]) -> bool:
    """True where a conclusion flips under one of these laws in more than `OFTEN` of the cases."""
    shares = [flip_share(dataset, conclusion, names) for conclusion in CONCLUSIONS] if names else []
    return any(np.nanmax(share, initial=0.0) > OFTEN for share in shares)


def finding(dataset: xr.Dataset) -> str:
    """`verdict` as one plain sentence."""
    baseline, outcome = str(dataset.attrs["baseline"]), verdict(dataset)
    if outcome.kind == UNTOUCHED:
        return f"The model cannot matter here: {baseline} has contact in no case."
    if outcome.kind == ALONE:
        return f"Nothing to compare on equal terms: no other law dissipates as {baseline} does."
    if outcome.kind == HARDLY:
        sentence = f"The model hardly matters here: {within_words(baseline)}"
    else:
        other = outcome.moved_by_yielding[:1]
        moves = [_moves(outcome.moved)] if outcome.alike or not other else []
        moves += [f"{yields_otherwise(dataset)}, {_moves(other)}"] if other else []
        by_model = outcome.kind == MODEL
        cause = "The model matters here" if by_model else "Yielding matters here, which is F_E and not the model"
        sentence = f"{cause}: against {baseline}, {'; '.join(moves)}"
    clauses, interfaces = [sentence], interface_names(dataset)
    for conclusion, words in FLIPS.items():
        most, law = most_frequent_flip(outcome.shares[conclusion], outcome.names, interfaces)
        if not np.isnan(most):
            clauses.append(f"{words} in {f'up to {percent(most)} of the cases ({law})' if most > 0.0 else 'none'}")
    return "; ".join([*clauses, *_of_few_cases(dataset, outcome), *aside(dataset, outcome.names)]) + "."


def _of_few_cases(dataset: xr.Dataset, outcome: Verdict) -> list[str]:
    """A clause for each interface of few cases with contact of which the sentence gives a number."""
    outputs = [output for output, *_ in (*outcome.moved[:NUMBERED], *outcome.moved_by_yielding[:1])]
    clauses, interfaces = [], interface_names(dataset)
    for index, interface in enumerate(interfaces):
        judged = at_interface(dataset, index)["judged"]
        count = int(judged.sel(conclusion="displacement", contact_model=dataset.attrs["baseline"]))
        if 0 < count < FEWEST and any(
            _label(words, interface, interfaces) in outputs for words in RUN_OUTPUTS.values()
        ):
            place_text = f" at {interface}" if len(interfaces) > 1 else ""
            clauses.append(f"only {count} case{'s' if count > 1 else ''} with contact{place_text}")
    return clauses


def within_words(baseline: str) -> str:
    """That no law is far from the baseline."""
    return (
        "in the middle 68 % of the cases every output of every law stays within "
        f"{100 * NOTABLE:.0f} % of that of {baseline}"
    )


def yields_otherwise(dataset: xr.Dataset) -> str:
    """How laws differ that do not yield as the baseline does."""
    yields = int(dataset["capped"].sel(contact_model=str(dataset.attrs["baseline"])))
    return f"{'without' if yields else 'with'} yielding"


def aside(dataset: xr.Dataset, names: list[str]) -> list[str]:
    """Which laws the sentence does not speak of."""
    others = [str(name) for name in dataset["contact_model"].values if name not in (*names, dataset.attrs["baseline"])]
    if not others or "reference_restitution_asked" not in dataset:
        return []
    return [f"left out of this finding, as they cannot be on equal terms: {', '.join(others)}"]


def _moves(moved: list[Moved]) -> str:
    """The outputs that move most, with numbers, and how many others do."""
    outputs: list[str] = []
    for output, law, low, high in moved[:NUMBERED]:
        verb, as_large = ("", "") if outputs else ("is ", " as large")
        outputs.append(f"{output} {verb}{times_words(low, high)} times{as_large} ({law})")
    n_more = len(moved) - len(outputs)
    if n_more:
        outputs.append(f"{n_more} more output{'s' if n_more > 1 else ''} off by over {100 * NOTABLE:.0f} %")
    return ", ".join(outputs) or f"no output is off by over {100 * NOTABLE:.0f} % in the middle 68 % of the cases"


def times_words(low: float, high: float) -> str:
    """Both ends of a range of ratios; of one case, or of like ones, one number."""
    return " to ".join(dict.fromkeys((f"{low:.2f}", f"{high:.2f}")))


def reach(low: float, high: float) -> float:
    """How far a range of ratios goes from 1, either way; 0 where there is none."""
    if np.isnan(high):
        return 0.0
    return max(high, 1.0 / low if low > 0.0 else np.inf)


def furthest(dataset: xr.Dataset, output: str, names: list[str]) -> tuple[str, float, float]:
    """(law, 16th, 84th percentile) of the law whose range of ratios goes furthest from 1; NaN where none has one."""
    part = dataset.sel(output=output, contact_model=names)
    ends = (part[name].values.tolist() for name in ("ratio_low", "ratio_high"))
    return max(zip(names, *ends, strict=True), key=lambda row: reach(*row[1:]))


def most_frequent_flip(share: Array, names: list[str], interfaces: list[str]) -> tuple[float, str]:
    """The largest of the shares by law and interface, and which it is of; NaN where none is judged."""
    share = share.reshape(len(names), len(interfaces))
    if np.isnan(share).all():
        return nan, ""
    law, interface = np.unravel_index(int(np.nanargmax(share)), share.shape)
    return float(share[law, interface]), _label(names[law], interfaces[interface], interfaces)


def percent(share: float) -> str:
    """A share in per cent, whole from 1 % on."""
    return f"{100 * share:.0f} %" if share >= 0.01 or share == 0.0 else f"{100 * share:.1g} %"


def flip_share(dataset: xr.Dataset, conclusion: str, names: list[str]) -> Array:
    """The share of the judged cases in which each of the laws disagrees, by interface; NaN where none is judged."""
    conclusions = dataset.sel(conclusion=conclusion, contact_model=names)
    judged = conclusions["judged"].values.astype(float)
    return np.asarray(
        np.divide(conclusions["flips"].values, judged, out=np.full(judged.shape, nan), where=judged > 0.0)
    )


def widest_interface(dataset: xr.Dataset) -> int:
    """The interface whose peak relative displacement the laws move furthest from the baseline's, by the 16-84 % range.

    Of the laws that the finding is about, of all where it is about none; the first interface where none moves any.
    """
    return int(np.argmax(displacement_reaches(dataset)))


def displacement_reaches(dataset: xr.Dataset) -> list[float]:
    """By interface how far the laws move its peak relative displacement, as `reach` has it; 0 where none does."""
    names = comparable_laws(dataset) or [str(name) for name in dataset["contact_model"].values]
    interfaces = interface_names(dataset)
    ranges = [furthest(dataset, _label(REACH, interface, interfaces), names) for interface in interfaces]
    return [reach(*law_range[1:]) for law_range in ranges]


def place_of_interface(dataset: xr.Dataset, interface: str | None = None) -> int:
    """Index of an interface by its name, by default that of `widest_interface`; raises as `index_of_interface`."""
    return widest_interface(dataset) if interface is None else index_of_interface(interface_names(dataset), interface)


def index_of_interface(names: Sequence[str], interface: str) -> int:
    """Index of an interface by its name; raises PoundingError for a name that none of them has."""
    if interface not in names:
        choices = " or ".join(f'"{name}"' for name in names)
        raise PoundingError(f'"{interface}" is not an interface{nearest(interface, names)}; it may be {choices}')
    return list(names).index(interface)


def which_interface(dataset: xr.Dataset, index: int) -> str:
    """Words for interface ``index``, with the rule if `widest_interface` has it; "" where there is one interface."""
    names = interface_names(dataset)
    if len(names) < 2:
        return ""
    rule = ", where the laws move the peak relative displacement most" if index == widest_interface(dataset) else ""
    return f"interface {names[index]} of {len(names)}{rule}"


def tables(dataset: xr.Dataset, baseline: str) -> dict[str, Any]:
    """The variables that a comparison adds to a scan: ratios, ranks, flips and gaps, as xarray takes them."""
    base, interfaces = place_of(dataset, baseline), range(len(interface_names(dataset)))
    outputs = outputs_of(dataset, baseline)
    spreads = np.full((3, len(outputs), dataset.sizes["contact_model"]), nan)
    for place, (output, cases) in enumerate(outputs.values()):
        for law, ratio in enumerate(ratios(output, base, cases)):
            if (defined := ratio[~np.isnan(ratio)]).size:
                spreads[:, place, law] = np.percentile(defined, (LOW, MIDDLE, HIGH))
    ranks = np.array([rank_agreement(output, base, cases) for output, cases in outputs.values()])
    flip_counts = [flips(dataset, baseline, index) for index in interfaces]
    gaps = [gap_without_contact(at_interface(dataset, index)) for index in interfaces]
    dims, by_conclusion = ("output", "contact_model"), ("conclusion", "contact_model")
    ratio_text = f"of the ratio to {baseline}'s, over the cases with contact under {baseline}"
    variables: dict[str, Any] = {
        "output": ("output", list(outputs)),
        "conclusion": ("conclusion", list(CONCLUSIONS), {"long_name": "; ".join(map(": ".join, CONCLUSIONS.items()))}),
    }
    for name, percentile, table in zip(("low", "median", "high"), (LOW, MIDDLE, HIGH), spreads, strict=True):
        variables[f"ratio_{name}"] = (dims, table, described("1", f"{percentile:g}th percentile {ratio_text}"))
    for name, kind, table in (
        ("rank_agreement", "median", ranks[:, :, 0]),
        ("rank_agreement_lowest", "at the gap and yield force of the lowest", ranks[:, :, 1]),
    ):
        variables[name] = (dims, table, described("1", f"Spearman's correlation of the motions' ranks, {kind}"))
    for column, name, words in (
        (0, "flips", f"cases in which a law disagrees with {baseline}"),
        (1, "judged", f"cases in which a law and {baseline} can be compared"),
    ):
        counts = [np.array([counts_of[conclusion][column] for conclusion in CONCLUSIONS]) for counts_of in flip_counts]
        variables[name] = (*_along(dataset, by_conclusion, counts), described("1", words))
    return variables | {"gap_without_contact": (*_along(dataset, gaps[0].dims, gaps), described("m", OPEN_GAP))}


def _along(dataset: xr.Dataset, dims: tuple[Any, ...], by_interface: list[Any]) -> tuple[Any, ...]:
    """Values of every interface with their dimensions, `interface` last where the dataset has it."""
    columns = [np.asarray(table) for table in by_interface]
    if "interface" not in dataset.dims:
        return dims, columns[0]
    return (*dims, "interface"), np.stack(columns, axis=-1)
