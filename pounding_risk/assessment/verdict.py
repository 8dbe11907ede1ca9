"""Adequate, inadequate, or it depends: the rule of the verdict, its sentences, and what follows for the gap.

A gap is adequate where the upper bound of the probability of contact is no more than the target, inadequate where the
lower bound is above it, and depends otherwise: the motions cannot tell. Bounds are those by recording. Motions whose
response failed count as contact against "adequate", and as none against "inadequate". Where each polarity alone would
lie on another side of the target, it depends as well: which way a record points is no property of the buildings.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.demands import Motions
from pounding_risk.assessment.options import Criterion, percent_words
from pounding_risk.assessment.sensitivity import CONTACT, Influence
from pounding_risk.statistics.proportions import Share, exact_bounds, least_upper_bound, motions_to_show
from pounding_risk.statistics.required_gap import RequiredGap, lognormal_share, rounded_up
from pounding_risk.units import GAP, say

ADEQUATE, INADEQUATE, DEPENDS = "adequate", "inadequate", "depends"
GOVERNING = 3  # motions that are named
NAMED_DOUBTS = 3  # doubts about records that are named
LARGEST_TARGET = 0.3  # that anyone would accept
MOST_RECORDINGS = 10_000  # that are looked for; nobody has more


@dataclass(frozen=True)
class Governing:
    """One of the motions that close most, and how much [m]."""

    record: str
    polarity: str
    closing: float


@dataclass(frozen=True)
class Verdict:
    """The verdict on one gap, its sentences and its evidence.

    ``conclusion`` says what follows for the gap: what to provide, and what would settle it. ``more_recordings`` is how
    many further recordings like these would settle a verdict that depends (`recordings_to_settle` states the rule): 0
    where it is settled, None where more of them would not do. ``margin`` is the gap over the required one at the
    percentile, NaN where nothing is required. ``runs`` are the cases of the dataset, of which some are ``sensitive``,
    in so far as they were recomputed, or ``failed``. ``by_polarity`` says that each polarity alone would lie on another
    side of the target.
    """

    word: str
    sentence: str
    conclusion: tuple[str, ...]
    more_recordings: int | None
    margin: float
    governing: tuple[Governing, ...]
    motions: int
    recordings: int
    independent: float
    runs: int
    sensitive: int
    failed: int
    evidence: tuple[str, ...]
    by_polarity: bool = False


class AssessedGap(NamedTuple):
    """A gap [m], and the criterion that it is held against."""

    gap: float
    criterion: Criterion

    @property
    def target(self) -> float:
        return self.criterion.target

    @property
    def confidence(self) -> float:
        return self.criterion.confidence


class Observations(NamedTuple):
    """Results of the motions at the assessed gap."""

    motions: Motions  # those of the assessed amplitude, with a finite closing
    at: str  # the amplitude in words
    contact: Share
    required: RequiredGap  # at the percentile that is asked for
    keeps_target: RequiredGap  # at the percentile that leaves the target
    independent: float
    lost: int  # motions without a finite response
    polarity: Influence
    counts: dict[str, int]
    touched: NDArray[np.bool_]  # by motion: contact at the assessed gap
    record_doubts: tuple[str, ...] = ()  # copies of records and records without motion, a sentence each


def judge(assessed: AssessedGap, observed: Observations) -> Verdict:
    """The verdict on a gap; the docstring of this module states the rule."""
    word = _word(assessed, observed)
    basis = _basis(assessed, observed)
    closing = observed.motions.closing[:, 0]
    order = np.argsort(-closing, kind="stable")[:GOVERNING]
    governing = tuple(
        Governing(observed.motions.records[index], observed.motions.polarities[index], float(closing[index]))
        for index in order
    )
    return Verdict(
        word=word,
        sentence=f"{word.capitalize()}: {_finding(assessed, observed)}{_why(word, assessed, observed)}",
        conclusion=conclusion(basis, {ADEQUATE: True, INADEQUATE: False}.get(word)),
        more_recordings=_more_recordings(word, basis),
        margin=assessed.gap / observed.required.gap if observed.required.gap > 0.0 else nan,
        governing=governing,
        motions=closing.size,
        recordings=int(observed.motions.recordings.max()) + 1,
        independent=observed.independent,
        runs=observed.counts["cases"],
        sensitive=observed.counts["sensitive"],
        failed=observed.counts["failed"],
        evidence=tuple(_evidence(assessed, observed, governing)),
        by_polarity=_hangs_on_polarity(observed),
    )


def _basis(assessed: AssessedGap, observed: Observations) -> Basis:
    closing = observed.motions.closing[:, 0]
    provided = observed.keeps_target.provided
    return Basis(
        gap=assessed.gap,
        criterion=assessed.criterion,
        contacts=observed.contact.count,
        motions=observed.contact.runs,
        lost=observed.lost,
        recordings=int(observed.motions.recordings.max()) + 1,
        independent=observed.independent,
        required=replace(observed.keeps_target, gap=provided),
        still_closing=int((closing > provided).sum()),
        amplitude=observed.at,
        hangs_on_polarity=_hangs_on_polarity(observed),
    )


def _hangs_on_polarity(observed: Observations) -> bool:
    return observed.polarity.what == CONTACT and observed.polarity.turns


def _more_recordings(word: str, basis: Basis) -> int | None:
    """Further recordings that would settle a verdict; 0 where it is settled, None where they would not."""
    if word != DEPENDS:
        return 0
    in_all = None if basis.hangs_on_polarity else recordings_to_settle(basis)
    return None if in_all is None else in_all - basis.recordings


def _word(assessed: AssessedGap, observed: Observations) -> str:
    share = observed.contact
    one = observed.independent / share.runs
    whole = (share.runs + observed.lost) * one
    _, high = exact_bounds((share.count + observed.lost) * one, whole, assessed.confidence)
    low, _ = exact_bounds(share.count * one, whole, assessed.confidence)
    if _hangs_on_polarity(observed):
        return DEPENDS
    return ADEQUATE if high <= assessed.target else INADEQUATE if low > assessed.target else DEPENDS


def _finding(assessed: AssessedGap, observed: Observations) -> str:
    share = observed.contact
    one = share.count < 2
    verb = ("closes" if one else "close") if observed.motions.alone is None else ("touches" if one else "touch") + " at"
    who = f"{share.count or 'none'} of {counted(share.runs, 'motion')} {observed.at} {verb}"
    low, high = share_words(share.low_recordings), share_words(share.high_recordings)
    bounds = f"{100 * assessed.confidence:g} % bounds {low} to {high}"
    return f"{who} a gap of {say(assessed.gap, GAP, 3)}: P(contact) {share_words(share.probability)} ({bounds})"


def _why(word: str, assessed: AssessedGap, observed: Observations) -> str:
    target = f"the target of {percent_words(assessed.target)}"
    if word == ADEQUATE:
        return f", within {target} throughout."
    if word == INADEQUATE:
        return f", above {target} throughout."
    if observed.polarity.turns:
        return f". Each polarity alone would answer otherwise to {target}: {observed.polarity.words}."
    least = least_upper_bound(observed.independent, assessed.confidence)
    if not observed.contact.count and least > assessed.target:
        needed = motions_to_show(assessed.target, assessed.confidence)
        reach = f", or a target of {np.ceil(100.0 * least):.0f} %" if least < LARGEST_TARGET else ""
        repair = f"it takes {needed} independent ones{reach}"
        return f". So few motions cannot show that a gap keeps {target}, though none closes it: {repair}."
    if observed.lost:
        return f". The bounds, which {counted(observed.lost, 'failed motion')} widen, lie on both sides of {target}."
    return f". The bounds lie on both sides of {target}."


def _evidence(assessed: AssessedGap, observed: Observations, governing: tuple[Governing, ...]) -> list[str]:
    counts = observed.counts
    sentences = [_margin(assessed, observed), _number(assessed, observed)]
    named = "; ".join(f"{motion.record} {motion.polarity} {say(motion.closing, GAP, 3)}" for motion in governing)
    sentences.append(f"The motions that close most: {named}.")
    tail = lognormal_share(observed.motions.closing[:, 0], assessed.gap)
    if not np.isnan(tail):
        sentences.append(
            f"Were what they close lognormal, P(contact) would be {share_words(tail)}: "
            "assumed of the tail, not counted."
        )
    runs = f"{counts['cases']} cases, {counts['simulated']} of them simulated, the others known exactly"
    checked = (
        f"{counts['sensitive']} sensitive of {counts['checked']} recomputed" if counts["checked"] else "none checked"
    )
    sentences.append(f"Behind it: {runs}; {counts['failed'] or 'none'} failed; {checked}.")
    sentences.append(_whose(assessed, observed))
    if observed.lost:
        sentences.append(
            f"Without a finite response, and counted against the verdict: {counted(observed.lost, 'motion')}."
        )
    if observed.record_doubts:
        more = len(observed.record_doubts) - NAMED_DOUBTS
        sentences.append(
            f"Records: {'; '.join(observed.record_doubts[:NAMED_DOUBTS])}{f'; and {more} more' if more > 0 else ''}."
        )
    return sentences


def _whose(assessed: AssessedGap, observed: Observations) -> str:
    """Sentence on how contact here differs from that of the free relative motion, by contact elsewhere in the row."""
    motions, touched = observed.motions, observed.touched
    if motions.alone is None:
        return "Contact does not depend on the contact model, F_E or sensitive runs."
    free = motions.alone[:, 0] > assessed.gap
    pushed, held = int((touched & ~free).sum()), int((free & ~touched).sum())
    counts = f"The free relative motion, without contact elsewhere in the row, closes the gap in {int(free.sum())}"
    if not pushed + held:
        return f"{counts} motions too: the same ones."
    parts = [
        f"contact elsewhere brings it in {pushed} more" if pushed else "",
        f"prevents it in {held}, which the required gaps count all the same" if held else "",
    ]
    return f"{counts} motions; {' and '.join(filter(None, parts))}."


def _margin(assessed: AssessedGap, observed: Observations) -> str:
    required, finite = observed.required, " with a finite response" if observed.lost else ""
    needs = f"{required.percentile:g} % of the motions{finite} need no more than {say(required.provided, GAP, 3)}"
    low, high = say(required.low, GAP, 3), say(rounded_up(required.high), GAP, 3)
    if required.low > 0.0:
        bounds = f"bounds {low} to {high}"
        if not required.bounded:
            bounds += ", the upper one only the largest seen: so few recordings do not bound it"
    else:
        upper = f"upper bound {high}, " if required.bounded else f"largest seen {high}, no upper bound, "
        bounds = f"{upper}no lower bound: so few recordings give none"
    ratio = f"{assessed.gap / required.gap:.2f} times that" if required.gap > 0.0 else "no less"
    return f"{needs} ({bounds}); the gap is {ratio if assessed.gap > 0.0 else 'closed'}."


def _number(assessed: AssessedGap, observed: Observations) -> str:
    """Sentence on how many independent motions there are, and what so many can show."""
    recordings, runs = int(observed.motions.recordings.max()) + 1, observed.contact.runs
    least = least_upper_bound(observed.independent, assessed.confidence)
    worth = f"{observed.independent:.0f}" if observed.independent >= 10.0 else f"{observed.independent:.2g}"
    many = "1 motion" if worth == "1" else f"{worth} motions"
    needed = motions_to_show(assessed.target, assessed.confidence)
    can = f"Even with no contact at all, {many} could only show P(contact) < {share_words(least)}"
    takes = f"showing {percent_words(assessed.target)} takes at least {needed} independent motions"
    who = f"{counted(runs, 'motion')} from {counted(recordings, 'recording')} (effective sample size {worth})"
    return f"{who}. {can}; {takes}."


def share_words(value: float) -> str:
    """A share as a probability is told: two or three digits in %, and small ones as less than 0.01 %."""
    if 0.0 < value < 1e-4:
        return "less than 0.01 %"
    return f"{100.0 * value:.3g} %" if value < 0.1 else f"{100.0 * value:.0f} %"


class Basis(NamedTuple):
    """Numbers that a conclusion rests on: motions, their closings, and how many independent motions they count for.

    ``contacts`` of the ``motions`` close the assessed gap; ``lost`` ones, not among them, have no finite response.
    ``required`` is the gap to provide, which ``still_closing`` of the motions, no more than the target, close all the
    same, with the bounds of its percentile. ``amplitude`` is in words. ``hangs_on_polarity`` says that each polarity
    alone would lie on another side of the target.
    """

    gap: float
    criterion: Criterion
    contacts: int
    motions: int
    lost: int
    recordings: int
    independent: float
    required: RequiredGap
    still_closing: int
    amplitude: str
    hangs_on_polarity: bool

    @property
    def worth(self) -> float:
        """Independent motions that one recording counts for, lost ones among them."""
        return self.independent * (1.0 + self.lost / self.motions) / self.recordings


def recordings_to_settle(basis: Basis) -> int | None:
    """Number of recordings after which the bounds leave the target on one side, were further ones like those so far.

    The least number R for which, with n = w R independent motions, w the independent motions of a recording so far, and
    the shares of contact that are seen, either the upper bound of `exact_bounds` is no more than the target, lost
    motions counted as contact, or the lower one is above it, lost motions counted as none. None where
    `MOST_RECORDINGS` do not settle it: the share seen is the target, or almost.

    Parameters
    ----------
    basis : Basis
        The motions so far.
    """
    whole = basis.motions + basis.lost
    shares = (basis.contacts / whole, (basis.contacts + basis.lost) / whole)

    def is_settled(recordings: int) -> bool:
        count = recordings * basis.worth
        low, _ = exact_bounds(shares[0] * count, count, basis.criterion.confidence)
        _, high = exact_bounds(shares[1] * count, count, basis.criterion.confidence)
        return bool(high <= basis.criterion.target or low > basis.criterion.target)

    most = basis.recordings
    while not is_settled(most):
        if most > MOST_RECORDINGS:
            return None
        most *= 2
    least = most // 2  # not settled, or fewer than there are
    while most - least > 1:
        middle = (least + most) // 2
        least, most = (least, middle) if is_settled(middle) else (middle, most)
    return most


def conclusion(basis: Basis, answer: bool | None) -> tuple[str, ...]:
    """Sentences of a conclusion: whether the gap is adequate, what to provide, and what would settle it.

    Parameters
    ----------
    basis : Basis
        What the verdict rests on.
    answer : bool or None
        True where the gap is adequate, False where it is not, None where the motions do not settle it.
    """
    sentences = (
        _answer(basis, answer),
        _provide(basis, answer),
        _settle(basis) if answer is None else "",
        _rest(basis),
    )
    return tuple(filter(None, sentences))


def _answer(basis: Basis, answer: bool | None) -> str:
    gap, target = say(basis.gap, GAP, 3), percent_words(basis.criterion.target)
    if answer is None:
        return (
            f"Whether a gap of {gap} keeps the probability of contact within {target} is not settled by these motions."
        )
    return f"A gap of {gap} is {'' if answer else 'not '}adequate for a probability of contact of {target}."


def _provide(basis: Basis, answer: bool | None) -> str:
    required, target = basis.required, percent_words(basis.criterion.target)
    confidence = percent_words(basis.criterion.confidence)
    if required.gap <= 0.0:
        return f"For {target} these motions require no gap at all."
    gap, low, high = (say(value, GAP, 3) for value in (required.gap, required.low, rounded_up(required.high)))
    if required.bounded:
        verb = f"Required is {gap}" if answer else f"Provide {gap}"
        return (
            f"{verb} ({confidence} bounds {low} to {high}) for a probability of contact of {target}; {_still(basis)}. "
            f"At {high} the upper bound of that probability is within {target} too."
        )
    bounds = f"{confidence} bounds: at least {low}, and none from above" if required.low > 0.0 else "without bounds"
    return (
        f"Provide at least {gap} for a probability of contact of {target}, an estimate ({bounds}); {_still(basis)}. "
        f"{_too_few(basis)}"
    )


def _still(basis: Basis) -> str:
    """Number of motions that close the required gap all the same, in words."""
    count = basis.still_closing
    if not count:
        return "none of the motions closes that gap"
    share = percent_words(round(count / basis.motions, 3))
    return f"{count} of the {basis.motions} motions ({share}) still close{'s' if count == 1 else ''} that gap"


def _too_few(basis: Basis) -> str:
    """Sentence that so few recordings keep no target at any gap, and how many could."""
    target = percent_words(basis.criterion.target)
    needed = recordings_to_settle(basis._replace(contacts=0, lost=0))
    at = f"{target} at {percent_words(basis.criterion.confidence)} confidence"
    answer = f"With {_recordings(basis.recordings).lower()} no gap can be shown to meet {at}"
    return f"{answer}; at least {needed} recordings without contact are needed." if needed else f"{answer}."


def _settle(basis: Basis) -> str:
    gap, share = say(basis.gap, GAP, 3), percent_words(round(basis.contacts / basis.motions, 3))
    if basis.hangs_on_polarity:
        return "It depends on the polarity of the records, which more of them need not decide."
    in_all = recordings_to_settle(basis)
    if in_all is None:
        return (
            f"More recordings do not settle the gap of {gap} while {share} of the motions close it: "
            "that is too near the target."
        )
    more = in_all - basis.recordings
    shown = "not adequate" if basis.contacts / basis.motions > basis.criterion.target else "adequate"
    many = "1 more recording" if more == 1 else f"{more} more recordings"
    return (
        f"About {many} would show a gap of {gap} to be {shown}, if their motions were as much alike as "
        f"these and closed it as often ({share})."
    )


def _rest(basis: Basis) -> str:
    count = f"{basis.motions} motion{'s' if basis.motions > 1 else ''} of {_recordings(basis.recordings).lower()}"
    return f"This rests on {count} {basis.amplitude}, and holds for sites and levels of shaking that they stand for."


def _recordings(count: int) -> str:
    return "One recording" if count == 1 else f"{count} recordings"
