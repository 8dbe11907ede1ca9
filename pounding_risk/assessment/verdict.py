"""Adequate, inadequate, or it depends: the rule of the verdict, its sentences, and what follows for the gap.

A gap is adequate where the upper bound of the probability of contact is no more than the target, inadequate where the
lower bound is above it, and depends otherwise: the motions cannot tell. Bounds are those by recording. Motions whose
response failed count as contact against "adequate", and as none against "inadequate". Where each polarity alone would
lie on another side of the target, it depends as well: which way a record points is no property of the buildings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil, inf, nan
from typing import NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk._common.order import enough_for
from pounding_risk.assessment.demands import Contact
from pounding_risk.assessment.fragility import not_run
from pounding_risk.assessment.options import Criterion, percent_words
from pounding_risk.assessment.sensitivity import CONTACT, Influence
from pounding_risk.statistics.proportions import exact_bounds, least_upper_bound, motions_to_show
from pounding_risk.statistics.required_gap import EVERY_GAP, RequiredGap, RunGaps, lognormal_share, rounded_up
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


class Basis(NamedTuple):
    """Numbers that a verdict rests on: motions, their closings, and how many independent motions they count for.

    ``contacts`` of the ``motions`` close the assessed gap, in ``unknown`` others neighbours may push the two together,
    as the row was run at the gaps ``run`` alone; ``lost`` ones, not among them, have no finite response.
    ``required`` is the gap to provide, which ``still_closing`` of the motions, no more than the target, close all the
    same, with the bounds of its percentile; where neighbours may push across it, they are those that do without a push,
    whose own required gap is ``free``. ``amplitude`` is in words. ``hangs_on_polarity`` says that each polarity
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
    unknown: int = 0
    run: RunGaps = EVERY_GAP
    free: float = nan

    @property
    def is_unrun(self) -> bool:
        """True where what neighbours push across the gap is not known, as the row was not run at it."""
        return self.unknown > 0

    @property
    def without_contact(self) -> Basis:
        """The same, had none of the motions brought contact."""
        return self._replace(contacts=0, unknown=0, lost=0)

    @property
    def target(self) -> str:
        """Accepted probability of contact in percent, as sentences state it."""
        return percent_words(self.criterion.target)

    def answer(self, recordings: int) -> bool | None:
        """True where a gap is adequate, False where it is not, None where bounds lie on both sides of the target.

        With this number of recordings, all like those of the dataset.
        """
        total = self.motions + self.lost
        n = self.independent * (1.0 + self.lost / self.motions) * recordings / self.recordings
        low, _ = exact_bounds(self.contacts / total * n, n, self.criterion.confidence)
        _, high = exact_bounds((self.contacts + self.unknown + self.lost) / total * n, n, self.criterion.confidence)
        return True if high <= self.criterion.target else False if low > self.criterion.target else None


def judge(
    contact: Contact, criterion: Criterion, polarity: Influence, counts: dict[str, int], doubts: Sequence[str] = ()
) -> Verdict:
    """The verdict on a gap; the docstring of this module states the rule.

    ``polarity`` is its influence on the probability of contact, ``counts`` are those of `Results.run_counts`, and
    ``doubts`` sentences on copies of records and records without motion.
    """
    closing, motions = contact.motions.closing[:, 0], contact.motions
    required = contact.required[criterion.percentile]
    target_gap = contact.required[criterion.target_percentile]
    may_push = motions.alone is not None and (target_gap.at_least or target_gap.is_between)
    counted_closing = motions.alone[:, 0] if motions.alone is not None and may_push else closing
    basis = Basis(
        gap=contact.gap,
        criterion=criterion,
        contacts=contact.at_gap.count,
        motions=contact.at_gap.runs,
        lost=contact.lost,
        recordings=int(motions.recordings.max()) + 1,
        independent=contact.independent,
        required=replace(target_gap, gap=target_gap.provided),
        still_closing=int((counted_closing > target_gap.provided).sum()),
        amplitude=contact.at,
        hangs_on_polarity=polarity.what == CONTACT and polarity.turns,
        unknown=int((contact.may_touch & ~contact.touched).sum()),
        run=contact.every.run,
        free=float(enough_for(counted_closing, np.array([criterion.target_percentile]))[0]),
    )
    answer = None if basis.hangs_on_polarity else basis.answer(basis.recordings)
    more_recordings: int | None = 0
    if answer is None:
        recordings_in_all = None if basis.hangs_on_polarity or basis.is_unrun else recordings_to_settle(basis)
        more_recordings = None if recordings_in_all is None else recordings_in_all - basis.recordings
    word = DEPENDS if answer is None else ADEQUATE if answer else INADEQUATE
    governing = tuple(
        Governing(motions.records[index], motions.polarities[index], float(closing[index]))
        for index in np.argsort(-closing, kind="stable")[:GOVERNING]
    )
    return Verdict(
        word=word,
        sentence=f"{word.capitalize()}: {_finding(contact, criterion)}{_reason(answer, basis, polarity)}",
        conclusion=conclusion(basis, answer),
        more_recordings=more_recordings,
        margin=contact.gap / required.gap if required.gap > 0.0 else nan,
        governing=governing,
        motions=closing.size,
        recordings=basis.recordings,
        independent=contact.independent,
        runs=counts["cases"],
        sensitive=counts["sensitive"],
        failed=counts["failed"],
        evidence=tuple(_evidence(contact, basis, required, governing, counts, doubts)),
        by_polarity=basis.hangs_on_polarity,
    )


def _finding(contact: Contact, criterion: Criterion) -> str:
    share = contact.at_gap
    is_singular = share.count < 2
    in_row = contact.motions.alone is not None and contact.every.run.is_known(contact.gap)
    verb = ("touches at" if is_singular else "touch at") if in_row else ("closes" if is_singular else "close")
    motions_text = f"{share.count or 'none'} of {counted(share.runs, 'motion')} {contact.at} {verb}"
    low, high = share_words(share.low_recordings), share_words(share.high_recordings)
    bounds = f"{100 * criterion.confidence:g} % bounds {low} to {high}"
    return f"{motions_text} a gap of {say(contact.gap, GAP, 3)}: P(contact) {share_words(share.probability)} ({bounds})"


def _reason(answer: bool | None, basis: Basis, polarity: Influence) -> str:
    target = f"the target of {basis.target}"
    if answer is not None:
        return f", {'within' if answer else 'above'} {target} throughout."
    if polarity.turns:
        return f". Each polarity alone would answer otherwise to {target}: {polarity.words}."
    if basis.is_unrun:
        failed_text = "in the runs at this gap pounding makes a storey collapse, or they fail"
        return f": {failed_text if basis.run.is_known(basis.gap) else not_run(basis.run, basis.gap)}."
    if basis.lost:
        return f". The bounds, which {counted(basis.lost, 'failed motion')} widen, lie on both sides of {target}."
    least_bound = least_upper_bound(basis.independent, basis.criterion.confidence)
    if not basis.contacts and least_bound > basis.criterion.target:
        needed_motions = motions_to_show(basis.criterion.target, basis.criterion.confidence)
        alternative = f", or a target of {np.ceil(100.0 * least_bound):.0f} %" if least_bound < LARGEST_TARGET else ""
        repair = f"it takes {needed_motions} independent ones{alternative}"
        return f". So few motions cannot show that a gap keeps {target}, though none closes it: {repair}."
    return f". The bounds lie on both sides of {target}."


def _evidence(
    contact: Contact,
    basis: Basis,
    required: RequiredGap,
    governing: Sequence[Governing],
    counts: dict[str, int],
    doubts: Sequence[str],
) -> Iterator[str]:
    yield _margin(basis, required)
    yield sample_size(basis)
    motions_text = "; ".join(f"{motion.record} {motion.polarity} {say(motion.closing, GAP, 4)}" for motion in governing)
    yield f"The motions that close most: {motions_text}."
    tail_share = lognormal_share(contact.motions.closing[:, 0], contact.gap)
    if not np.isnan(tail_share):
        share = share_words(tail_share)
        yield f"Were what they close lognormal, P(contact) would be {share}: assumed of the tail, not counted."
    part = f"{counts['simulated']} of them simulated, the others known exactly"
    runs = f"{counted(counts['cases'], 'case')}, {part if counts['simulated'] < counts['cases'] else 'all simulated'}"
    checked_text = (
        f"{counts['sensitive']} sensitive of {counts['checked']} recomputed" if counts["checked"] else "none checked"
    )
    if unrun_count := counts.get("unpushed", 0):
        cases = f"{unrun_count} of {counts['cases']} cases are not run, in which a known motion would have to be pushed"
        yield f"Behind it: the motions without contact; {cases}; {counts['failed'] or 'none'} failed."
    else:
        yield f"Behind it: {runs}; {counts['failed'] or 'none'} failed; {checked_text}."
    yield _contact_elsewhere(contact)
    if basis.lost:
        count = counts.get("collapsed", 0)
        cause = f"; in {count} of them a storey collapses, for which no gap is wide enough" if count else ""
        if number := counts.get("struck", 0):
            cause += (
                f"; in {number} of them pounding in the row makes a storey collapse, so that contact here is not known"
            )
        yield f"Without a finite response, and counted against the verdict: {counted(basis.lost, 'motion')}{cause}."
    if doubts:
        more_doubts = len(doubts) - NAMED_DOUBTS
        yield f"Records: {'; '.join(doubts[:NAMED_DOUBTS])}{f'; and {more_doubts} more' if more_doubts > 0 else ''}."


def _margin(basis: Basis, required: RequiredGap) -> str:
    finite_text = " with a finite response" if basis.lost else ""
    amount = "at least" if required.at_least else "no more than"
    who, count = f"{required.percentile:g} % of the motions", basis.motions
    if (1.0 - required.percentile / 100.0) * count < 1.0:
        motions = "The one motion" if count == 1 else f"All {count} motions"
        who = f"{motions} ({required.percentile:g} % of {count}, rounded up)"
    verb = "needs" if count == 1 else "need"
    needs_text = f"{who}{finite_text} {verb} {amount} {say(rounded_up(required.shown), GAP, 3)}"
    low, high = say(required.low, GAP, 3), say(rounded_up(required.high), GAP, 3)
    if required.low > 0.0:
        bounds = f"bounds {low} to {high}"
        if required.is_pushed:
            bounds += ", the upper one without what neighbours push across gaps at which the row was not run"
        elif not required.bounded:
            bounds += ", the upper one only the largest seen: so few recordings do not bound it"
    else:
        upper = f"upper bound {high}, " if required.bounded else f"largest seen {high}, no upper bound, "
        bounds = f"{upper}no lower bound: so few recordings give none"
    ratio = f"{basis.gap / required.shown:.2f} times that" if required.shown > 0.0 else "no less"
    return f"{needs_text} ({bounds}); the gap is {ratio if basis.gap > 0.0 else 'closed'}."


def sample_size(basis: Basis) -> str:
    """Sentence on how many independent motions there are, and what so many can show."""
    least_bound = least_upper_bound(basis.independent, basis.criterion.confidence)
    worth_text = f"{basis.independent:.0f}" if basis.independent >= 10.0 else f"{basis.independent:.2g}"
    motions_text = "1 motion" if worth_text == "1" else f"{worth_text} motions"
    needed_motions = motions_to_show(basis.criterion.target, basis.criterion.confidence)
    sample_text = f"{counted(basis.motions, 'motion')} from {counted(basis.recordings, 'recording')}"
    can_text = f"Even with no contact at all, {motions_text} could only show P(contact) < {bound_words(least_bound)}"
    takes_text = f"showing {basis.target} takes at least {needed_motions} independent motions"
    recordings = recordings_to_settle(basis.without_contact)
    takes_text += f", those of {recordings} such recordings" if recordings and recordings != needed_motions else ""
    return f"{sample_text} (effective sample size {worth_text}). {can_text}; {takes_text}."


def _contact_elsewhere(contact: Contact) -> str:
    """Sentence on how contact here differs from that of the free relative motion, by contact elsewhere in the row."""
    if contact.motions.alone is None:
        return "Contact does not depend on the contact model, F_E or sensitive runs."
    closes = contact.motions.alone[:, 0] > contact.gap
    gains, losses = int((contact.touched & ~closes).sum()), int((closes & ~contact.touched).sum())
    count = counted(closes.sum(), "motion")
    text = f"The free relative motion, without contact elsewhere in the row, closes the gap in {count}"
    if not gains + losses:
        return f"{text} too: the same ones."
    effects = [
        f"brings it in {gains} more, whose closings with contact the required gaps count" if gains else "",
        f"prevents it in {losses}, which the required gaps count all the same" if losses else "",
    ]
    return f"{text}; contact elsewhere {' and '.join(filter(None, effects))}."


def bound_words(share: float) -> str:
    """An upper bound as `share_words` has it, rounded up."""
    return share_words(ceil(100.0 * share) / 100.0 if share >= 0.1 else ceil(1e5 * share) / 1e5)


def share_words(share: float) -> str:
    """A share as a probability is written: two or three digits in %, and small ones as less than 0.01 %."""
    if 0.0 < share < 1e-4:
        return "less than 0.01 %"
    return f"{100.0 * share:.3g} %" if share < 0.1 else f"{100.0 * share:.0f} %"


def recordings_to_settle(basis: Basis) -> int | None:
    """Number of recordings after which the bounds leave the target on one side, were further ones like those so far.

    The least number R for which, with n = w R independent motions, w the independent motions of a recording so far, and
    the shares of contact that are seen, either the upper bound of `exact_bounds` is no more than the target, lost
    motions counted as contact, or the lower one is above it, lost motions counted as none. None where
    `MOST_RECORDINGS` do not settle it: the share seen is the target, or almost.
    """
    most = basis.recordings
    while basis.answer(most) is None:
        if most > MOST_RECORDINGS:
            return None
        most *= 2
    least = most // 2  # not settled, or fewer than there are
    while most - least > 1:
        middle = (least + most) // 2
        least, most = (middle, most) if basis.answer(middle) is None else (least, middle)
    return most


def conclusion(basis: Basis, answer: bool | None) -> tuple[str, ...]:
    """Sentences of a conclusion: whether the gap is adequate, what to provide, and what would settle it.

    The answer is True where the gap is adequate, False where it is not, None where the motions do not settle it.
    """
    gap = say(basis.gap, GAP, 3)
    if answer is None:
        first = f"Whether a gap of {gap} keeps the probability of contact within {basis.target} is not decided by these"
        sentences = [f"{first} motions.", _provide(basis, answer), _settle(basis)]
    else:
        first = f"A gap of {gap} is {'' if answer else 'not '}adequate for a probability of contact of {basis.target}."
        sentences = [first, _provide(basis, answer)]
    count = f"{counted(basis.motions, 'motion')} of {_recordings_text(basis.recordings)}"
    scope = f"This rests on {count} {basis.amplitude}, and holds for sites and levels of shaking that they stand for."
    return (*sentences, scope)


def _provide(basis: Basis, answer: bool | None) -> str:
    """Sentences on the gap to provide, its bounds, and the motions that close it all the same."""
    required, target = basis.required, basis.target
    confidence = percent_words(basis.criterion.confidence)
    if basis.lost > basis.criterion.target * (basis.motions + basis.lost):
        lost_text = f"{basis.lost} of {counted(basis.motions + basis.lost, 'motion')} have no finite response"
        return f"No gap can be shown to keep {target}: {lost_text}; the gaps required are those of the others."
    if required.gap <= 0.0 and not required.is_between:
        return f"For {target} these motions require no gap at all."
    count, prefix = basis.still_closing, "at least " * required.at_least
    note = "none of the motions closes that gap"
    if count:
        share = percent_words(round(count / basis.motions, 3))
        note = f"{count} of the {basis.motions} motions ({share}) still close{'s' if count == 1 else ''} that gap"
    widths = (rounded_up(required.shown), required.low, rounded_up(required.high))
    gap, low, high = (say(width, GAP, 3) for width in widths)
    bounds = f"{confidence} bounds: at least {low}, and none from above" if required.low > 0.0 else "without bounds"
    note += " without a push by neighbours" if required.at_least else ""
    if required.is_between:
        free = say(rounded_up(basis.free), GAP, 3)
        note = f"without a push by neighbours {free} would do, and whether less than {gap} does is not known: "
        note += not_run(basis.run, required.gap)
    if required.is_pushed:
        provide = f"Provide {prefix}{gap} for a probability of contact of {target} ({bounds}); {note}."
        at_confidence = f" at {confidence} confidence" * required.is_between
        return f"{provide} No gap is shown to be enough{at_confidence}: {not_run(basis.run, inf)}."
    if required.bounded:
        verb = f"Required is {gap}" if answer else f"Provide {gap}"
        return (
            f"{verb} ({confidence} bounds {low} to {high}) for a probability of contact of {target}; {note}. "
            f"At {high} the upper bound of that probability is within {target} too."
        )
    text = f"With {_recordings_text(basis.recordings)} no gap can be shown to meet {target} at {confidence} confidence"
    number = recordings_to_settle(basis.without_contact)
    if number:
        text += f"; at least {number} recordings without contact are needed"
    return f"Provide at least {gap} for a probability of contact of {target}, an estimate ({bounds}); {note}. {text}."


def _settle(basis: Basis) -> str:
    """Sentence on how many recordings would settle the verdict."""
    gap, share = say(basis.gap, GAP, 3), percent_words(round(basis.contacts / basis.motions, 3))
    if basis.hangs_on_polarity:
        return "It depends on the polarity of the records, which more of them need not decide."
    if basis.is_unrun:
        repair = "weaker motions or stronger storeys" if basis.run.is_known(basis.gap) else f"the gap of {gap}"
        return f"More recordings do not settle it: a scan with {repair} does."
    recordings_in_all = recordings_to_settle(basis)
    if recordings_in_all is None and basis.lost:
        return f"More recordings do not settle the gap of {gap} while so many motions have no finite response."
    if recordings_in_all is None:
        return (
            f"More recordings do not settle the gap of {gap} while {share} of the motions close it: "
            "that is too near the target."
        )
    more_recordings = recordings_in_all - basis.recordings
    word = "not adequate" if basis.contacts / basis.motions > basis.criterion.target else "adequate"
    number = "1 more recording" if more_recordings == 1 else f"{more_recordings} more recordings"
    return (
        f"About {number} would show a gap of {gap} to be {word}, if their motions were as much alike as "
        f"these and closed it as often ({share})."
    )


def _recordings_text(count: int) -> str:
    return "one recording" if count == 1 else f"{count} recordings"
