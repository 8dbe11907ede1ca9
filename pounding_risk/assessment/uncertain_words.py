"""Sentences on uncertain numbers crossed with motions: the verdict, the parts, and what would narrow the answer."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.options import Criterion, percent_words
from pounding_risk.assessment.uncertain_samples import Samples
from pounding_risk.assessment.verdict import ADEQUATE, DEPENDS, INADEQUATE, bound_words, share_words
from pounding_risk.statistics.closings import CrossedClosings
from pounding_risk.statistics.proportions import least_upper_bound, motions_to_show
from pounding_risk.statistics.sobol import LEAST_SAMPLES, power_of_two
from pounding_risk.units import GAP, Quantity, rounded, say

OUTPUT_WORDS = {
    "contact_probability": "P(contact)",
    "required_gap": "the required gap",
    "log_median_closing": "the logarithm of the median closing",
    "contact": "whether there is contact",
    "log_closing": "the logarithm of the closing",
}
COMPONENTS = {
    "motions": "the motions",
    "parameters": "the uncertain numbers",
    "interaction": "both together",
    "parameters and interaction": "the uncertain numbers, alone and together with the motions",
}
LESS_SCATTER = " less the scatter of the gap"
WIDE = 0.2  # bounds of shares, above which there are too few samples or points
MOSTLY = 0.6  # of the variance of the bounds, from which one side is named


def verdict_of(
    closings: CrossedClosings, subject: Samples, index: int, gap: float, level: int | None, criterion: Criterion
) -> tuple[str, str]:
    """Adequate, inadequate or depends by the rule of `verdict`, with bounds over samples and motions; its sentence."""
    contact = closings.contact(gap, criterion.confidence)
    share, low, high = float(contact.value[0]), float(contact.low[0]), float(contact.high[0])
    polarities, is_closed = np.array(subject.motions(index).polarities), closings.closing > gap
    by_polarity = {
        str(name): closings.of_polarity(is_closed, polarities == name) for name in dict.fromkeys(polarities.tolist())
    }
    sides = {chance > criterion.target for chance in by_polarity.values()}
    word = DEPENDS if len(sides) > 1 else ADEQUATE if high <= criterion.target else INADEQUATE
    word = word if word != INADEQUATE or low > criterion.target else DEPENDS
    is_unrun = word == ADEQUATE and subject.may_be_pushed(index, gap)
    word = DEPENDS if is_unrun else word
    separator = ", " if closings.is_drawn else " × "
    motions_text = f"{counted(len(closings.closing), 'sample')}{separator}{subject.motions_words(level)}"
    bounds = f"{100 * criterion.confidence:g} % bounds {share_words(low)} to {share_words(high)}"
    deviation, gap_text = subject.gap_deviation(index), f"a gap of {say(gap, GAP, 3)}"
    if deviation > 0.0:  # where gaps are uncertain the nominal one, from which that of a sample departs
        gap_text = f"a nominal gap of {say(gap, GAP, 3)} plus its scatter (deviation {say(deviation, GAP, 2)})"
    finding = f"{word.capitalize()}: over {motions_text} P(contact) at {gap_text} is {share_words(share)} ({bounds})"
    target = f"the target of {percent_words(criterion.target)}"
    if len(sides) > 1:
        shares_text = ", ".join(f"{name} {share_words(chance)}" for name, chance in by_polarity.items())
        return word, f"{finding}. Each polarity alone would answer otherwise to {target}: {shares_text}."
    if is_unrun:
        pushes = "what neighbours may push across it, which was not run: scan the samples at this gap"
        return word, f"{finding}, within {target} but for {pushes}."
    if word == DEPENDS:
        return word, f"{finding}. These bounds lie on both sides of {target}."
    return word, f"{finding}, {'within' if word == ADEQUATE else 'above'} {target} throughout."


def gap_scatter(interface: xr.Dataset) -> float:
    """Standard deviation over the samples of the gap [m], 0 where it is known."""
    return float(interface.get("gap_deviation", 0.0))


def offset_words(subject: Samples, index: int) -> str:
    """A sentence where the gaps of samples are not in the mean the scene's own, which is the nominal one; else ""."""
    offset = subject.gap_offset(index)
    if not offset:
        return ""
    side, amount = "wider" if offset > 0.0 else "narrower", say(abs(offset), GAP, 3)
    return (
        f"{subject.interfaces[index]}: the gaps of the samples are {amount} {side} in the mean than the scene's own of "
        f"{say(subject.gap(index), GAP, 3)}, which is the nominal one: a required nominal gap stands for gaps that are "
        f"{amount} {side} in the mean."
    )


def of_few(closings: CrossedClosings, criterion: Criterion) -> Iterator[str]:
    """Sentences where there are too few motions or samples for the target."""
    least_bound = least_upper_bound(closings.counted.without_contact, criterion.confidence)
    if least_bound > criterion.target:
        needed_motions = motions_to_show(criterion.target, criterion.confidence)
        unit_text = "recordings, all with as many samples" if closings.is_drawn else "of each"
        yield (
            f"Few: the motions count as {closings.counted.motions:.3g} independent ones, beside "
            f"{counted(closings.counted.samples, 'sample')}. Even without any contact these could only show P(contact) "
            f"< {bound_words(least_bound)}; the target of {percent_words(criterion.target)} takes {needed_motions} "
            f"{unit_text}."
        )


def lost_words(interface: str, closings: CrossedClosings) -> str:
    """A sentence on outcomes without a finite response; "" where there are none."""
    count, total = int((~np.isfinite(closings.closing)).sum()), closings.closing.size
    if not count:
        return ""
    cause = "without a finite response, or whose run in the row fails, as where pounding makes a storey collapse"
    return f"{interface}: {count} of {total} outcomes {cause}, count as contact at every gap, in lower bounds as none."


def samples_words(interface: xr.Dataset) -> str:
    """Sentence on the samples whose P(contact) exceeds the target; "" where motions are drawn with samples."""
    if "samples_over_target" not in interface:
        return ""
    share, low, high = (share_words(float(interface[f"samples_over_target{end}"])) for end in ("", "_low", "_high"))
    target = percent_words(float(interface.attrs["target"]))
    return f"In {share} of the samples (bounds {low} to {high}) P(contact) under these motions exceeds {target}."


def parts_words(interface: xr.Dataset) -> str:
    """Sentence on the shares that motions, parameters and their interaction have in the variance."""
    share, deviation = _by_component(interface, "variance_share"), _by_component(interface, "dispersion")
    if not np.isfinite(share["motions"]):
        if "interaction" not in share:
            return "No motion was drawn twice, or all are of one recording: draw more samples for the motions' share."
        return "One recording does not show what motions and parameters contribute."
    is_of_closing = str(interface["chosen_output"].item()) in OUTPUT_WORDS
    scatter = gap_scatter(interface) > 0.0
    whose = ("ln (closing less the scatter of the gap)" if scatter else "ln closing") if is_of_closing else "the output"
    ordered = sorted((name for name in COMPONENTS if name in share), key=lambda name: -share[name])
    sources = ", ".join(f"{_percent(share[name])} from {COMPONENTS[name]}" for name in ordered)
    sources = sources.replace(" from", " comes from", 1)
    unit = str(interface["dispersion"].attrs["units"])
    total = rounded(deviation["total"], 2) if unit == "1" else _in_unit(deviation["total"], unit)
    sentence = f"Of the variance of {whose} {sources} (deviation {total} in all)."
    zeros = int(interface.get("outcomes_without_closing", 0))
    if is_of_closing and zeros:
        sentence += (
            f" {counted(zeros, 'outcome')} in which the scatter is the larger {'counts' if zeros == 1 else 'count'} "
            "as the least of the others."
        )
    return sentence


def closing_words(interface: xr.Dataset) -> str:
    """The output whose variance is split, where that is the closing."""
    return "the closing without contact" + LESS_SCATTER * (gap_scatter(interface) > 0.0)


def narrowing(interface: xr.Dataset, closings: CrossedClosings, gap: float, criterion: Criterion) -> list[str]:
    """Sentences on what would narrow the answer most: knowing a number, more recordings, or more samples."""
    return [words_of_number(interface, criterion), *_dispersion(interface), *_bounds(closings, gap, criterion)]


def words_of_number(interface: xr.Dataset, criterion: Criterion) -> str:
    """Sentence on the number with the largest first-order index, if it stands out from chance and from the next."""
    output = str(interface["chosen_output"].item())
    words = OUTPUT_WORDS.get(output, output.replace("_", " "))
    indices = interface.sel(output=output)
    first, low, high = (indices[f"first_order{ending}"].values for ending in ("", "_low", "_high"))
    names = [str(name) for name in interface["uncertain_number"].values]
    if not np.isfinite(first).any():
        if float(indices["output_deviation"]) > 0.0:
            samples = counted(interface.sizes["sample"], "sample")
            return f"On which number {words} depends most is not known from {samples}."
        return f"Over the samples {words} does not vary: no number changes it."
    order = np.argsort(-np.nan_to_num(first, nan=-1.0))
    lead = int(order[0])
    if not low[lead] > 0.0:
        return (
            f"No number stands out: the largest share of the variance of {words} over the samples, "
            f"{_percent(first[lead])} of {names[lead]}, is not significant at {100 * criterion.confidence:g} %."
        )
    deviation = float(indices["output_deviation"])
    narrowed = deviation * float(np.sqrt(max(1.0 - first[lead], 0.0)))
    unit = str(indices["output_unit"].item())
    change = f"its deviation over the samples would fall from {_in_unit(deviation, unit)} to {_in_unit(narrowed, unit)}"
    overlaps = [names[number] for number in order[1:] if high[number] > low[lead] and first[number] > 0.0]
    lead_words = (
        f"Knowing {names[lead]} exactly would narrow {words} most: it has {_percent(first[lead])} of the variance over "
        f"the samples (bounds {_percent(low[lead])} to {_percent(high[lead])}), and {change}."
    )
    if overlaps:
        lead_words += f" Its bounds overlap those of {', '.join(overlaps)}."
    return lead_words


def indices_words(interface: xr.Dataset) -> str:
    """Sentences on what the shares are from, and where samples or points are too few for them; "" where none vary."""
    indices = interface.sel(output=str(interface["chosen_output"].item()))
    if not float(indices["output_deviation"]) > 0.0:
        return ""
    samples, points = interface.sizes["sample"], int(interface.get("sobol_points", 0))
    is_designed = points > 0 and bool(indices["first_order_of_design"])
    sentences = []
    if samples < LEAST_SAMPLES:
        there_are = f"there {'is' if samples == 1 else 'are'} {samples}"
        sentences.append(
            f"First-order shares from samples are withheld: their bounds hold from {LEAST_SAMPLES} on, and {there_are}."
        )
    elif points:
        source = f"the N = {points} points of --sobol" if is_designed else f"the {samples} samples"
        sentences.append(f"First-order shares are from {source}, whose bounds are narrower.")
    design_kinds = ("first_order", "total_order") if is_designed else ("total_order",)
    for label, count, kinds in (
        (f"N = {points}", points, design_kinds if points else ()),
        (f"{samples} samples", samples, () if is_designed else ("first_order",)),
    ):
        width = max((float((indices[f"{kind}_high"] - indices[f"{kind}_low"]).max()) for kind in kinds), default=0.0)
        if width > WIDE:  # bounds narrow with the root of the count
            number = power_of_two(int(np.ceil(count * (width / WIDE) ** 2)))
            verb = "is too small" if count == points and kinds == design_kinds else "are few"
            sentences.append(
                f"{label} {verb}: bounds of shares are up to {_percent(width)} wide; {number} would bring them to "
                f"about {_percent(WIDE)}."
            )
    shares = [kind for kind in ("first_order", "total_order") if kind in indices]
    if any(bool(((indices[kind] < 0.0) | (indices[kind] > 1.0)).any()) for kind in shares):
        sentences.append(
            "A share below 0 or above 1 is so by an error of the estimate, which more samples or points reduce."
        )
    return " ".join(sentences)


def _dispersion(interface: xr.Dataset) -> Iterator[str]:
    """Sentence on how much the total dispersion would shrink, and that motions stay as they are."""
    is_of_closing = str(interface["chosen_output"].item()) in OUTPUT_WORDS
    if not (is_of_closing and np.isfinite(_by_component(interface, "variance_share")["motions"])):
        return
    deviation = _by_component(interface, "dispersion")
    # Of drawn motions a share is one of the variance in all, not of that of the samples alone.
    is_drawn = "parameters" not in deviation
    first = interface["first_order"].sel(output="log_closing" if is_drawn else "log_median_closing").values
    if not np.isfinite(first).any():
        return
    lead = int(np.nanargmax(first))
    removed_variance = min(max(float(first[lead]), 0.0), 1.0) * deviation["total" if is_drawn else "parameters"] ** 2
    remaining_deviation = float(np.sqrt(max(deviation["total"] ** 2 - removed_variance, 0.0)))
    name = str(interface["uncertain_number"].values[lead])
    total_text, remaining_text = rounded(deviation["total"], 2), rounded(remaining_deviation, 2)
    closing_text = "the closing" + LESS_SCATTER * (gap_scatter(interface) > 0.0)
    change = f"fall to {remaining_text}" if remaining_text != total_text else "hardly change"
    yield (
        f"The total dispersion of {closing_text}, {total_text}, would {change} were {name} known; "
        f"{rounded(deviation['motions'], 2)} is that of the motions, which no such knowledge narrows."
    )


def _bounds(closings: CrossedClosings, gap: float, criterion: Criterion) -> Iterator[str]:
    """Sentence on whether more recordings or more samples would narrow the bounds of P(contact)."""
    intervals = []
    for samples, motions in ((1, 1), (1, 2), (2, 1)):
        contact = closings.contact(gap, criterion.confidence, times=(samples, motions))
        intervals.append((float(contact.low[0]), float(contact.high[0])))
    now_text, recordings_text, samples_text = (f"{share_words(low)} to {share_words(high)}" for low, high in intervals)
    sizes = [high - low for low, high in intervals]
    gains = sizes[0] - sizes[1], sizes[0] - sizes[2]
    if max(gains) < 0.02 * sizes[0]:
        return
    source = "of recordings and samples alike"
    if gains[0] >= MOSTLY * sum(gains):
        source = "mostly of the recordings"
    elif gains[1] >= MOSTLY * sum(gains):
        source = "mostly of the samples"
    yield (
        f"The bounds of P(contact), {now_text}, come {source}: twice as many recordings like these would make them "
        f"{recordings_text}, twice as many samples {samples_text}."
    )


def _percent(share: Any) -> str:
    return f"{100.0 * float(share):.0f} %"


def _by_component(indices: xr.Dataset, name: str) -> dict[str, float]:
    return dict(zip(indices["component"].values.tolist(), indices[name].values.tolist(), strict=True))


def _in_unit(deviation: float, unit: str) -> str:
    if unit == "1":
        return rounded(deviation, 2)
    return say(deviation, Quantity(unit.replace("m/s2", "m/s^2"), -np.inf, np.inf, ""), 3)
