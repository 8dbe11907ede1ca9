"""How many more recordings would settle a verdict, held against the binomial distribution, and what is concluded."""

from __future__ import annotations

import pytest
from scipy.stats import binom

from pounding_risk.assessment.options import read_criterion
from pounding_risk.assessment.verdict import Basis, conclusion, recordings_to_settle, sample_size
from pounding_risk.statistics.required_gap import RequiredGap

BOUNDED = RequiredGap(90.0, 0.092, 0.076, 0.115, True, 0.09)
UNBOUNDED = RequiredGap(90.0, 0.092, 0.076, 0.1, False, 0.09)


def basis(contacts: int, motions: int, *, target: float = 0.1, **more: object) -> Basis:
    """Motions that are each a recording of their own, unless told otherwise."""
    given = {"recordings": motions, "independent": float(motions), "required": BOUNDED, "still_closing": 1, "lost": 0}
    given |= {"amplitude": "at 0.3 g", "hangs_on_polarity": False, "gap": 0.08} | more
    return Basis(criterion=read_criterion(target), contacts=contacts, motions=motions, **given)


@pytest.mark.parametrize("target", [0.01, 0.1, 0.16, 0.3])
def test_without_contact_the_number_is_that_of_the_power_law(target):
    """The upper bound of none in n is 1 - 0.025^(1/n): the least n by trial, since P(none) = (1 - target)^n."""
    needed = next(n for n in range(1, 1000) if (1.0 - target) ** n <= 0.025)
    assert recordings_to_settle(basis(0, 5, target=target)) == needed


@pytest.mark.parametrize(("contacts", "motions", "target"), [(1, 20, 0.1), (1, 4, 0.1), (3, 10, 0.16), (1, 10, 0.16)])
def test_the_bounds_leave_the_target_where_the_binomial_tails_say(contacts, motions, target):
    """At whole counts, k of n for each multiple of the motions: the bound is past the target where the tail of the
    binomial distribution at the target is no more than 2.5 %."""
    needed = recordings_to_settle(basis(contacts, motions, target=target))
    for factor in range(1, 60):
        count, runs = factor * contacts, factor * motions
        few = binom.cdf(count, runs, target) <= 0.025  # so few would be rare at the target
        many = binom.sf(count - 1, runs, target) < 0.025  # so many would be
        assert bool(few or many) is (runs >= needed), (count, runs)


def test_recordings_count_for_what_they_are_worth():
    """Two motions of a recording that are worth one: twice the motions, the same recordings."""
    alone = recordings_to_settle(basis(1, 20))
    assert recordings_to_settle(basis(2, 40, recordings=20, independent=20.0)) == alone
    assert recordings_to_settle(basis(2, 40, recordings=20, independent=40.0)) == pytest.approx(alone / 2, abs=1)


def test_independent_motions_are_counted_in_recordings_too():
    """At a target of 10 %, of recordings that count for 7/6 of a motion each."""
    assert 0.9**36 <= 0.025 < 0.9**35
    assert "takes at least 36 independent motions." in sample_size(basis(1, 20))
    told = sample_size(basis(1, 24, recordings=12, independent=14.0))
    assert told.endswith("takes at least 36 independent motions, those of 31 such recordings.")  # 30 · 7 / 6 = 35


def test_a_share_at_the_target_is_never_settled():
    assert recordings_to_settle(basis(2, 20)) is None
    assert recordings_to_settle(basis(0, 20, lost=4)) is None  # 4 of 24 may have closed it, or none: both sides
    told = " ".join(conclusion(basis(2, 20), None))
    assert "More recordings do not settle the gap of 80 mm while 10 % of the motions close it" in told


def test_a_settled_one_needs_no_more():
    assert recordings_to_settle(basis(0, 40)) <= 40
    assert recordings_to_settle(basis(40, 40)) <= 40


def test_the_conclusion_is_the_one_that_can_be_signed():
    told = conclusion(basis(3, 20), None)
    assert (
        told[0]
        == "Whether a gap of 80 mm keeps the probability of contact within 10 % is not decided by these motions."
    )
    assert told[1].startswith("Provide 92 mm (95 % bounds 76 mm to 115 mm) for a probability of contact of 10 %; ")
    assert "1 of the 20 motions (5 %) still closes that gap" in told[1]
    more = recordings_to_settle(basis(3, 20)) - 20
    assert told[2].startswith(f"About {more} more recordings would show a gap of 80 mm to be not adequate, if ")
    (*_, fewer, _) = conclusion(basis(1, 20), None)
    assert " would show a gap of 80 mm to be adequate, if " in fewer
    assert told[3].startswith("This rests on 20 motions of 20 recordings at 0.3 g, and holds for sites and levels")


def test_an_answer_asks_for_no_more_recordings():
    adequate, inadequate = conclusion(basis(0, 40), True), conclusion(basis(30, 40), False)
    assert adequate[0] == "A gap of 80 mm is adequate for a probability of contact of 10 %."
    assert adequate[1].startswith("Required is 92 mm (95 % bounds")
    assert inadequate[0] == "A gap of 80 mm is not adequate for a probability of contact of 10 %."
    assert inadequate[1].startswith("Provide 92 mm")
    assert not any("more recordings" in sentence for sentence in (*adequate, *inadequate))


def test_what_has_no_bound_says_so_and_what_it_takes():
    """One of three recordings, worth a motion each: (1 - 0.1)^36 is the first below 2.5 %."""
    (_, provide, *_) = conclusion(basis(1, 3, required=UNBOUNDED), None)
    assert "95 % bounds: at least 76 mm, and none from above" in provide
    assert (
        "With 3 recordings no gap can be shown to meet 10 % at 95 % confidence; at least 36 recordings without"
        in provide
    )
    assert "115" not in provide
    (_, provide, *_) = conclusion(basis(1, 3, required=UNBOUNDED.__class__(90.0, 0.092, 0.0, 0.1, False, 0.09)), None)
    assert provide.startswith(
        "Provide at least 92 mm for a probability of contact of 10 %, an estimate (without bounds);"
    )


def test_nothing_required_is_told():
    nothing = RequiredGap(90.0, 0.0, 0.0, 0.0, True, 0.0)
    assert conclusion(basis(0, 40, required=nothing), True)[1] == "For 10 % these motions require no gap at all."


def test_a_verdict_that_hangs_on_the_polarity_is_not_settled_by_more():
    told = conclusion(basis(20, 40, hangs_on_polarity=True), None)
    assert "It depends on the polarity of the records, which more of them need not decide." in told
