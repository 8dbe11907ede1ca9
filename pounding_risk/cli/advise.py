"""The command `advise`: what to write for the contact of a scene, and which outputs depend on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.options import NONE, Figure, Overrides, Scene, option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_pairs, print_table

if TYPE_CHECKING:
    from pounding_risk.studies.advice import Advice
    from pounding_risk.studies.advice_stiffness import StiffnessRange

ORDER = 65


def advise(
    scene: Scene,
    overrides: Overrides = NONE,
    gap: Annotated[str | None, option("The gap.", "the scene's")] = None,
    floor_length: Annotated[str, option("Length of the floors of buildings that give none.")] = "20 m",
    figure: Figure = None,
) -> None:
    """What to write for the contact, and what depends on it."""
    from pounding_risk.cli._common.options import read_option, read_optional
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.advice import advise as run
    from pounding_risk.units import FLOOR_LENGTH, GAP

    length = read_option("--floor-length", floor_length, FLOOR_LENGTH)
    clear = read_optional("--gap", gap, GAP)
    study = read_scene(scene, overrides)
    with ProgressDisplay("advise", "scans") as progress:
        advice = run(study, gap=clear, floor_length=length, progress=progress)
    print_advice(advice)
    draw(figure, "advice.advice_figure", advice)


def print_advice(advice: Advice) -> None:
    """Print what to write, the range of stiffness with the published rules, what depends on what, and the finding."""
    print(f"{advice.scene}: gap {advice.gap}, {advice.touched} of {advice.cases} cases with contact\n")
    print("What to write in [[interface]]\n")
    for line in advice.lines:
        where = f"   # {line.interface}" if line.interface else ""
        if line.line or where:
            print(f"{line.line or '# nothing'}{where}")
        print(f"    {line.why}")
    for stiffness_range in advice.ranges:
        _print_range(stiffness_range)
    if advice.influences:
        _print_influences(advice)
    print()
    print_pairs([*(("told", words) for words in advice.left_out), ("finding", advice.finding)])


def _print_range(stiffness_range: StiffnessRange) -> None:
    """Print the range of one interface, and where the published rules lie."""
    from pounding_risk.studies.advice_stiffness import ms, stiffness_words
    from pounding_risk.units import MASS, say

    print(
        f"\n{stiffness_range.interface}: a reduced mass of {say(stiffness_range.mass, MASS, 3)} strikes at "
        f"{stiffness_range.speed:.2g} m/s"
    )
    shortest, longest = ms(stiffness_range.shortest), ms(stiffness_range.longest)
    limits = f"a contact of {shortest} (wave through a floor) to {longest} (T/10), undamped"
    if stiffness_range.is_empty:
        print(f"  no stiffness gives {limits}\n")
    else:
        low, high = (
            stiffness_words(value, stiffness_range.unit, 3) for value in (stiffness_range.low, stiffness_range.high)
        )
        print(f"  {low} to {high} give {limits}\n")
    if stiffness_range.is_column:
        print("  of floors that strike each other: columns, which are struck here, are not judged by it\n")
    rows = [
        (
            "the scene's",
            "",
            stiffness_words(stiffness_range.own, stiffness_range.unit),
            ms(stiffness_range.duration),
            "–" if stiffness_range.is_column else stiffness_range.verdict or "–",
            "",
        )
    ]
    rows += [
        (
            rule.name,
            stiffness_words(rule.published, rule.unit, 3),
            stiffness_words(rule.equivalent, stiffness_range.unit, 3),
            ms(rule.duration),
            "–" if stiffness_range.is_column else rule.verdict or "–",
            f"{rule.source} ({rule.known})",
        )
        for rule in stiffness_range.rules
    ]
    print_table(("rule", "published", "here, as long a contact", "lasts", "verdict", "source"), rows, "lrrrll")


def _print_influences(advice: Advice) -> None:
    """Print a line for each output at each place, with a verdict on each factor."""
    from pounding_risk.studies.advice import FACTORS, JUDGED, LITTLE, MUCH, OUTPUTS, said

    print(
        f"\nWhat depends on what: median change of the cases with contact. Stiffness: a {JUDGED:g}th to {JUDGED:g} "
        f"times the scene's. Below {100 * LITTLE:.0f} % it does not depend, above {100 * MUCH:.0f} % it does.\n"
    )
    rows = []
    for (output, place), value in advice.now.items():
        ones = [advice.influence(factor, output, place) for factor in FACTORS]
        cells = ["–" if one is None else one.words for one in ones]
        rows.append((OUTPUTS[output].words, place, said(value, output), *cells))
    print_table(("output", "of", "now, median", *FACTORS), rows, "llrllll")
