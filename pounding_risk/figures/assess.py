"""Figure of an assessment: P(contact) against the gap with its bounds, fragilities, and rates against the gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.fragility import SCALED, Fragility
from pounding_risk.assessment.rates import rate_lines
from pounding_risk.assessment.separations.rules import COMBINATIONS
from pounding_risk.figures.style import QUIET, STYLES, blank, law_words, title
from pounding_risk.motions.levels import say_level
from pounding_risk.results.amplitudes import intensity_label, intensity_quantity, intensity_shown, own
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.proportions import exact_bounds
from pounding_risk.units import GAP, YIELD_FORCE, say_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from pounding_risk.assessment.assess import Assessment, InterfaceAssessment

Array = NDArray[np.float64]

BLUE, ORANGE, GREEN = STYLES[0][0], STYLES[1][0], STYLES[2][0]
POINTS = 400
ROOM = 1.15  # of the axis of gaps, beyond what is drawn on it
MOST_EMPTY = 2.0  # times what the motions need: a rule that asks for more stands beyond the axis
BAND = "one standard error to either side"
MOST_YIELD_CURVES = 4
RATE_MARKS = "osDv^Phx*"  # of gaps for annual rates, each named in the legend
MOST_NAMED = 2  # interfaces whose findings stand in the title
VERDICT_WORDS = {"depends": "not settled"}


def assessment_figure(assessment: Assessment, note: str = "") -> Figure:
    """P(contact) against the gap, fragilities at the gap, and with a hazard curve the rate of contact against the gap.

    One row for each interface.

    Parameters
    ----------
    assessment : Assessment
        As `assess` gives it.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels for each interface, three with a hazard curve.
    """
    rows, columns = len(assessment.interfaces), 3 if assessment.hazard_rows else 2
    figure, axes = blank(rows, columns, (6.5 * columns, 1.0 + 5.0 * rows))
    for row, interface in enumerate(assessment.interfaces):
        _adequacy(axes[row, 0], interface, assessment)
        _fragilities(axes[row, 1], interface, assessment)
        if assessment.hazard_rows:
            _rates(axes[row, 2], interface, assessment)
        if rows > 1:
            axes[row, 0].set_title(interface.name, fontsize=10, loc="left")
    first = assessment.interfaces[0]
    finding = (
        "; ".join(_finding(interface, rows > 1) for interface in assessment.interfaces)
        if rows <= MOST_NAMED
        else _counted(assessment)
    )
    motions = (
        f"{counted(first.verdict.motions, 'motion')} of {counted(first.verdict.recordings, 'recording')} {first.at}"
    )
    title(figure, finding, f"{assessment.title}: {motions}", note)
    return figure


def _counted(assessment: Assessment) -> str:
    """Sentence on how many gaps of a row have which verdict, and where contact is most likely."""
    words = [interface.verdict.word for interface in assessment.interfaces]
    counts = ", ".join(f"{words.count(word)} {VERDICT_WORDS.get(word, word)}" for word in dict.fromkeys(words))
    worst = max(assessment.interfaces, key=lambda interface: interface.contact_at_gap().probability)
    share = worst.contact_at_gap()
    return (
        f"Of {len(words)} gaps {counts}; most contact at {worst.name}: {share.count} of {counted(share.runs, 'motion')}"
    )


def _finding(interface: InterfaceAssessment, named: bool) -> str:
    share, name = interface.contact_at_gap(), f"{interface.name}: " if named else ""
    word = VERDICT_WORDS.get(interface.verdict.word, interface.verdict.word)
    rate = interface.rate_verdict
    by_rate = "" if rate is None else f", and {VERDICT_WORDS.get(rate.word, rate.word)} for {rate.words}"
    return (
        f"{name}{own(interface.gap, GAP)} is {word}: {share.count} of {counted(share.runs, 'motion')} close it{by_rate}"
    )


def _adequacy(axis: Any, interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Draw the exact share of the motions that close each gap, its bounds, target, gap, required gap and code rules."""
    closing = np.array(interface.closing)
    separations = _asked(interface)
    widest = _widest(interface, separations)
    gaps = np.linspace(0.0, widest, POINTS)
    count = (closing[:, None] > gaps).sum(axis=0)
    weight = interface.verdict.independent / closing.size
    low, high = exact_bounds(weight * count, weight * np.full(POINTS, closing.size), assessment.confidence)
    # The step curve falls at each motion's own closing.
    steps, heights = np.concatenate([[0.0], closing, [widest]]), 1.0 - np.arange(closing.size + 1) / closing.size
    bounds = f"{100 * assessment.confidence:g} % bounds, {interface.verdict.independent:.0f} independent motions"
    axis.fill_between(1e3 * gaps, low, high, color=BLUE, alpha=0.15, linewidth=0.0, label=bounds)
    axis.stairs(heights, 1e3 * steps, baseline=None, color=BLUE, linewidth=1.8, label="motions that close the gap")
    axis.axhline(assessment.target, color=QUIET, linestyle=":", linewidth=1.2, label=f"target {assessment.target:g}")
    axis.axvline(1e3 * interface.gap, color="black", linewidth=1.4, label=f"the gap, {own(interface.gap, GAP)}")
    needed = next(required for required in interface.required if required.percentile == assessment.percentile)
    words = f"required by {needed.percentile:g} %: {say_in(needed.provided, 'mm', 3)} (bar: bounds)"
    axis.axvline(1e3 * needed.gap, color=ORANGE, linestyle="--", linewidth=1.4, label=words)
    axis.plot([1e3 * needed.low, 1e3 * needed.high], [1.04, 1.04], color=ORANGE, linewidth=3.0, solid_capstyle="butt")
    _rules(axis, separations, widest)
    axis.set(xlabel="gap [mm]", ylabel="P(contact) [1]", xlim=(0.0, 1e3 * widest), ylim=(0.0, 1.12))
    _legend(axis, 2)


def _legend(axis: Any, columns: int) -> None:
    """Place the legend below the axis, where it covers nothing."""
    position = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "ncols": columns}
    axis.legend(fontsize=8, frameon=False, handlelength=2.6, columnspacing=1.2, **position)


def _asked(interface: InterfaceAssessment) -> dict[str, float]:
    """Separations of the combinations [m], by their names."""
    rules = {
        comparison.row.rule: comparison.upper
        for comparison in interface.separations
        if comparison.row.rule in COMBINATIONS
    }
    return {name: upper for name in COMBINATIONS if (upper := rules.get(name)) is not None}


def _widest(interface: InterfaceAssessment, separations: dict[str, float]) -> float:
    """End of the axis of gaps [m]: beyond all that motions and rules need, as far as the motions stay in sight."""
    motions = max(interface.closing[-1], interface.gap, 1e-6)
    rules = [upper for upper in separations.values() if upper <= MOST_EMPTY * motions]
    return ROOM * max([motions, *rules])


def _rules(axis: Any, separations: dict[str, float], widest: float) -> None:
    """Draw the combinations as marks along the top; an arrow at the end stands for one beyond the axis."""
    for marker, (name, upper) in zip("v^D", separations.items(), strict=False):
        beyond = upper > widest
        label = f"{name.upper()}: {say_in(upper, 'mm', 3)} of elastic peaks" + (", beyond the axis" if beyond else "")
        position, shape = (widest, ">") if beyond else (upper, marker)
        axis.plot(1e3 * position, 1.08, shape, color=GREEN, markersize=6, clip_on=False, label=label)


def _fragilities(axis: Any, interface: InterfaceAssessment, assessment: Assessment) -> None:
    contact = next(curve for curve in interface.fragility if curve.what == "contact" and curve.gap == interface.gap)
    yields = _some(
        [curve for curve in interface.fragility if curve.what == "yield" and not curve.fault], interface.own_model
    )
    if yields:
        axis.set_title(_yield_words(yields, interface), fontsize=9.5)
    drawn = [curve for curve in (contact, *yields) if not curve.fault]
    axis.set(xlabel=intensity_label(assessment.intensity), ylabel="P(failure) [1]", ylim=(-0.03, 1.12))
    if not drawn:
        from textwrap import fill

        words = fill(f"No fragility at this gap: {contact.fault}", 46)
        axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", va="center", fontsize=9.5, color=QUIET)
        return
    most = max(max(curve.median * np.exp(2.2 * curve.dispersion), curve.stripes[-1].im) for curve in drawn)
    im = np.linspace(most / POINTS, most, POINTS)
    for (colour, dash), curve in zip(STYLES, drawn, strict=False):
        _curve(axis, im, curve, (colour, dash))
    _capacities(axis, interface, contact)
    _hazard(axis, interface, assessment)
    axis.set_xlim(0.0, most * intensity_shown(assessment.intensity)[1])
    _legend(axis, 1)


def _yield_words(drawn: list[Fragility], interface: InterfaceAssessment) -> str:
    """Contact model of the drawn curves of yielding, and their number where not all are drawn."""
    curve_count = sum(curve.what == "yield" and not curve.fault for curve in interface.fragility)
    some = f", {len(drawn)} of {curve_count} curves" if curve_count > len(drawn) else ""
    return f"yielding: {law_words(str(drawn[0].contact_model))}{some}"


def _hazard(axis: Any, interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Draw the range of the hazard curve, with the probability of contact in 50 years by motions of that range."""
    if not assessment.hazard_rows:
        return
    unit, size = intensity_shown(assessment.intensity)
    ends = [assessment.hazard_rows[end][0] * size for end in (0, -1)]
    pairs = zip(interface.fragility, interface.rates, strict=True)
    here = [rate for curve, rate in pairs if curve.what == "contact" and curve.gap == interface.gap and not rate.fault]
    words = f"hazard curve, {ends[0]:.3g} to {ends[1]:.3g} {unit}".rstrip()
    for rate in here:
        least = "at least " if rate.at_least else ""
        words += f": contact in 50 years {least}{100.0 * rate.fifty_years:.2g} %"
        words += f", about {100.0 * rate.missing:.0f} % of failures beyond it" if rate.at_least else ""
    axis.axvspan(*ends, ymin=0.0, ymax=0.03, color=QUIET, alpha=0.6, linewidth=0.0, label=words)


def _rates(axis: Any, interface: InterfaceAssessment, assessment: Assessment) -> None:
    """Draw the annual rate of contact against the gap with its bounds, the target, the gap, and the gap for it."""
    required = [gap for gap in interface.gaps_for_rates if not gap.fault]
    lines = rate_lines(interface.rates, interface.gaps_for_rates)
    axis.set(xlabel="gap [mm]", ylabel="rate of contact [1/year]")
    if not lines.gaps.size:
        from textwrap import fill

        fault = next((gap.fault for gap in interface.gaps_for_rates if gap.fault), "no fragility of contact")
        words = fill(f"No rate of contact: {fault}", 46)
        axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", va="center", fontsize=9.5, color=QUIET)
        return
    bounds = f"{100 * assessment.confidence:g} % bounds, of the motions alone"
    axis.fill_between(1e3 * lines.gaps, lines.low, lines.high, color=BLUE, alpha=0.15, linewidth=0.0, label=bounds)
    axis.plot(1e3 * lines.gaps, lines.annual, color=BLUE, linewidth=1.8, label=f"contact, under {assessment.hazard}")
    axis.set_yscale("log")
    axis.axvline(1e3 * interface.gap, color="black", linewidth=1.4, label=f"the gap, {own(interface.gap, GAP)}")
    if assessment.target_rate is not None:
        words = f"target {assessment.target_rate_words}"
        axis.axhline(assessment.target_rate, color=QUIET, linestyle=":", linewidth=1.4, label=words)
    for number, gap in enumerate(required):
        is_target = gap.rate == assessment.target_rate
        colour, mark = ORANGE if is_target else BLUE, RATE_MARKS[number % len(RATE_MARKS)]
        least = "at least " if gap.at_least else ""
        label = f"for {gap.words}: {least}{say_in(gap.gap, 'mm', 3)}"
        axis.plot(1e3 * gap.gap, gap.rate, mark, color=colour, markersize=8 if is_target else 5, zorder=3, label=label)
    bars = [gap for gap in required if gap.rate == assessment.target_rate]
    for gap in bars:
        ends = 1e3 * np.array([gap.low, gap.high])
        look = {"linewidth": 3.0, "alpha": 0.6, "solid_capstyle": "butt"}
        axis.plot(ends, [gap.rate] * 2, color=ORANGE, label="its bounds", **look)
    reach = [interface.gap, *(gap.gap for gap in required), *(gap.high for gap in bars)]
    widest = ROOM * max(length for length in reach if np.isfinite(length))
    axis.set_xlim(0.0, 1e3 * widest)
    shown = (lines.gaps <= widest) & (lines.annual > 0.0)
    axis.set_ylim(0.5 * lines.annual[shown].min(initial=required[-1].rate if required else np.inf), None)
    axis.secondary_yaxis("right", functions=(_turned, _turned)).set_ylabel("return period [years]")
    _legend(axis, 2)


def _turned(values: Array) -> Array:
    """Return periods of rates, and rates of return periods."""
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / np.asarray(values, dtype=float))


def _some(yields: list[Fragility], model: str) -> list[Fragility]:
    """Some curves of yielding: of the scene's own contact model or the grid's last, from the first to the last F_E."""
    models = [str(curve.contact_model) for curve in yields]
    shown = model if model in models else models[-1] if models else ""
    same = [curve for curve in yields if curve.contact_model == shown]
    indices = np.linspace(0, len(same) - 1, min(MOST_YIELD_CURVES, len(same))).round().astype(int)
    return [same[index] for index in indices]


def _curve(axis: Any, im: Array, curve: Fragility, look: tuple[str, str]) -> None:
    """Draw one fragility with the band of its standard errors, and the shares at its intensities."""
    colour, dash = look
    about = "contact" if curve.yield_force is None else f"$F_E$ {_force(curve.yield_force)}"
    about += f", gap {own(curve.gap, GAP)}"
    _, size = intensity_shown(curve.intensity)
    median = say_level(curve.median, intensity_quantity(curve.intensity), 3)
    label = f"{about}: median {median}, dispersion {curve.dispersion:.2f}"
    label += f" ({SCALED}, times {curve.factor:.2g})" if curve.method == SCALED else ""
    axis.plot(im * size, curve.probability(im), color=colour, linestyle=dash, linewidth=1.8, label=label)
    if curve.what == "contact":
        low, high = _band(im, curve)
        axis.fill_between(im * size, low, high, color=colour, alpha=0.15, linewidth=0.0, label=BAND)
    if curve.method != SCALED:
        where = [stripe.im * size for stripe in curve.stripes]
        shares = [stripe.count / stripe.runs for stripe in curve.stripes]
        sizes = [12.0 + 40.0 * stripe.runs / max(other.runs for other in curve.stripes) for stripe in curve.stripes]
        axis.scatter(where, shares, sizes, color=colour, alpha=0.55, linewidths=0.0, zorder=3)


def _force(force: float) -> str:
    """Words for a yield force [N]; of a floor that never yields, those for columns."""
    return own(force, YIELD_FORCE) if np.isfinite(force) else "of columns"


def _band(im: Array, curve: Fragility) -> tuple[Array, Array]:
    """One standard error to either side, in the argument of the curve (delta method)."""
    argument = np.log(im / curve.median) / curve.dispersion
    first, second = curve.errors[0], curve.errors[1] * argument
    variance = first**2 + second**2 + 2.0 * curve.correlation * first * second
    spread = np.sqrt(np.maximum(variance, 0.0)) / curve.dispersion
    low, high = (fragility_curve(np.exp(argument + side * spread), 1.0, 1.0) for side in (-1.0, 1.0))
    return low, high


def _capacities(axis: Any, interface: InterfaceAssessment, contact: Fragility) -> None:
    """Draw the intensities at which scaled motions close the gap, as a step curve, where the curve is from scaling."""
    is_own = contact.intensity == interface.intensity  # in which the amplitude is stated
    if contact.method != SCALED or contact.fault or not is_own or interface.amplitude is None:
        return
    _, size = intensity_shown(contact.intensity)
    reach = np.sort(interface.amplitude * interface.gap / np.array(interface.closing)) * size
    shares = np.arange(1, reach.size + 1) / reach.size
    axis.plot(reach, shares, ".", color=BLUE, markersize=6, label="motions, scaled until they close the gap")
