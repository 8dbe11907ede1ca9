"""What follows from a verdict: the gap to provide, what it rests on, and how many more recordings would settle it."""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk.assessment.options import Criterion, percent_words
from pounding_risk.assessment.proportions import exact_bounds
from pounding_risk.assessment.required_gap import RequiredGap
from pounding_risk.units import GAP, say

MOST_RECORDINGS = 10_000  # that are looked for; nobody has more


class Basis(NamedTuple):
    """What a conclusion rests on: the motions, what they close, and what they are worth.

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
    """Recordings in all after which the bounds leave the target on one side, were further ones like those there are.

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
    """Sentences that an engineer can sign: whether the gap will do, what to provide, and what would settle it.

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
    gap, low, high = (say(value, GAP, 3) for value in (required.gap, required.low, required.high))
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
    """How many of the motions close the required gap all the same."""
    count = basis.still_closing
    if not count:
        return "none of the motions closes that gap"
    share = percent_words(round(count / basis.motions, 3))
    return f"{count} of the {basis.motions} motions ({share}) still close{'s' if count == 1 else ''} that gap"


def _too_few(basis: Basis) -> str:
    """That so few recordings keep no target at any gap, and how many could."""
    target = percent_words(basis.criterion.target)
    needed = recordings_to_settle(basis._replace(contacts=0, lost=0))
    told = f"{_recordings(basis.recordings)} cannot show that any gap keeps {target}"
    return f"{told}: that takes {needed} in all, none of whose motions closes it." if needed else f"{told}."


def _settle(basis: Basis) -> str:
    gap, share = say(basis.gap, GAP, 3), percent_words(round(basis.contacts / basis.motions, 3))
    if basis.hangs_on_polarity:
        return "It hangs on the polarity of the records, which more of them need not settle."
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
