"""Separations that building codes ask for, as data: clause, year, formula, what each needs, how its text is known.

    >>> from pounding_risk.assessment.separations.rules import RULES
    >>> RULES["asce7"].clause, RULES["asce7"].verification, RULES["asce7"].superseded
    ('ASCE/SEI 7-10, 12.12.3', 'clause read', 'ASCE/SEI 7-16 and 7-22')

The text of a clause is known in one of three ways, which ``verification`` says: "clause read", "quoted" by others, or
"from memory" of the profession; ``source`` names the text, or who quotes it. Only rules of the first kind may be relied
on without looking up the clause. A fourth kind, "derived", belongs to no code: its formula is derived and tested here.
``superseded`` names later editions of a clause, as far as they are known here, from memory: that none is named does not
make a clause the current one. A later edition is not in force because it is published: the authority of the site
decides which one holds, and ``in_force`` says what is known of that.

Codes work with displacements of their own design level, which ``level`` names from memory; here d is a building's peak
displacement times `Site.factors`. Of given displacements under a code's reduced forces that is the number that
``factor`` names, from memory; of the linear model's under unreduced motions it stands for C_d / R, q_d / q and so on.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._common.plugins import Registry
from pounding_risk.errors import PoundingError
from pounding_risk.statistics.separations import Pair, abs_sum, cqc, srss
from pounding_risk.units import STANDARD_GRAVITY

ZONES = ("I", "II", "III")
INTENSITIES = (6, 7, 8, 9)
HALF_GRAVITY = 0.5 * STANDARD_GRAVITY  # m/s²
STRUCTURES = ("frame", "frame and walls", "walls")
# How the text of a rule's clause is known; the order is that of trust.
DERIVED, READ, QUOTED, MEMORY = VERIFICATIONS = ("derived", "clause read", "quoted", "from memory")


class Site(NamedTuple):
    """What codes ask about two neighbours besides their displacements; left and right in every pair.

    Parameters
    ----------
    heights : pair of float, optional
        Heights above the ground [m].
    factors : pair of float
        A code's design displacement over that of the linear model.
    aligned : bool
        Whether floors are at the same levels.
    alike : bool
        Whether the height and the kind of structure are the same too.
    zone : {"I", "II", "III"}, optional
        Zone of Mexico City.
    intensity : {6, 7, 8, 9}, optional
        Intensity of seismic fortification in China.
    structure : {"frame", "frame and walls", "walls"}
        Structure of the building that asks for more.
    ground : float, optional
        Design acceleration a_g S at the surface [m/s²].
    """

    heights: tuple[float, float] | None = None
    factors: tuple[float, float] = (1.0, 1.0)
    aligned: bool = False
    alike: bool = False
    zone: str | None = None
    intensity: int | None = None
    structure: str = "frame"
    ground: float | None = None


class Case(NamedTuple):
    """Two buildings as a rule takes them; displacements [m] may be arrays, one value a motion."""

    displacements: Pair
    periods: Pair  # s
    dampings: Pair
    site: Site

    @property
    def design(self) -> tuple[Any, Any]:
        """The displacements [m] that codes call inelastic or design displacements."""
        left, right = (np.asarray(displacement, float) for displacement in self.displacements)
        return left * self.site.factors[0], right * self.site.factors[1]

    @property
    def lower(self) -> float:
        """Height of the lower roof [m], the highest level at which the two can touch."""
        return min(self.site.heights or (np.nan, np.nan))


class Rule(NamedTuple):
    """A separation rule; ``function`` gives the separation [m] of a `Case` that has what the rule ``needs``."""

    name: str
    title: str
    clause: str
    year: int | None  # None where no code says it
    formula: str
    verification: str  # one of VERIFICATIONS
    source: str  # the text that was read, who quotes it, or where the formula is derived; "" from memory
    needs: tuple[str, ...]  # of Site, besides displacements; those without a default
    assumes: tuple[str, ...]  # keys of Site that have a default and take part
    function: Callable[[Case], Any]
    superseded: str = ""  # later editions of the clause; "" where none is known here
    factor: str = ""  # what turns displacements under the code's reduced forces into those of its formula
    level: str = ""  # the ground motion that the clause means
    in_force: str = ""  # which edition holds where, with who says so; "" where nothing is known here
    has_periods: bool = False  # whether the function takes the periods and damping ratios

    @property
    def is_checked(self) -> bool:
        """Whether the clause itself was read, or the formula is derived here."""
        return self.verification in (DERIVED, READ)


def _mexico(case: Case, share: dict[str, float], peaks: tuple[Any, Any]) -> Any:
    """Sum of both setbacks at the level of the lower roof, halved where the two are alike."""
    setbacks = [np.maximum(0.05, displacement + share[case.site.zone or ""] * case.lower) for displacement in peaks]
    return (setbacks[0] + setbacks[1]) * (0.5 if case.site.aligned and case.site.alike else 1.0)


def _china(case: Case) -> float:
    """Width of the joint from the lower height, the intensity and the structure that asks for more."""
    step = {6: 5.0, 7: 4.0, 8: 3.0, 9: 2.0}[case.site.intensity or 0]
    frame = 0.1 + 0.02 * max(case.lower - 15.0, 0.0) / step
    return max(0.1, {"frame": 1.0, "frame and walls": 0.7, "walls": 0.5}[case.site.structure] * frame)


def _turkey(case: Case) -> Any:
    """SRSS of the displacements under unreduced forces, times 0.5 or 0.25, and at least a minimum by height."""
    least = 0.03 + 0.01 * max(case.lower - 6.0, 0.0) / 3.0
    return np.maximum(least, (0.25 if case.site.aligned else 0.5) * srss(*case.design))


def _asce41(case: Case) -> Any:
    """SRSS, at most 4 % of the height where contact is possible."""
    return np.minimum(srss(*case.design), 0.04 * case.lower)


def _eurocode8_factor(case: Case) -> float:
    return 0.7 if case.site.aligned else 1.0


US_EDITIONS = "what the adopted IBC names: 7-10 in 2012 and 2015, 7-16 in 2018 and 2021, 7-22 in 2024 (from memory)"
EUROCODES = (
    "what the country adopts with its national annex; the second generation is the revised set of all Eurocodes. In "
    "the United Kingdom the first applies until it is withdrawn on 30 March 2028 (istructe.org, 18 January 2024)"
)
INDIA = (
    "this edition, as reported: IS 1893 (Part 1):2025 was withdrawn on 3 March 2026 and the edition of 2016 restored "
    "(owlbrief.com 11897 after The Hindu; riskavoider.com 6750)"
)
IBC_TEXT = "the International Building Code's text (up.codes, building separations, eq. 16-64)"

# What the rules of one code share: the factor of its displacements, the ground motion that it means, and its editions.
ASCE7: dict[str, Any] = {"factor": "Cd / Ie", "level": "design earthquake, 2/3 of MCE_R", "in_force": US_EDITIONS}
ASCE7_2022: dict[str, Any] = ASCE7 | {"level": f"{ASCE7['level']}; not read whether the clause asks for more"}
UBC97: dict[str, Any] = {
    "superseded": "the International Building Code, since 2000", "factor": "R", "level": "10 % in 50 years (475 years)"
}  # fmt: skip
EUROCODE8: dict[str, Any] = {
    "superseded": "the second generation, EN 1998-1-1:2024 and EN 1998-1-2",
    "factor": "qd, which is q unless stated otherwise",
    "level": "no-collapse: 475 years, times the importance factor",
    "in_force": EUROCODES,
}

# Needs, assumptions and function of rules that combine both design displacements and ask for nothing else.
Combining = tuple[tuple[str, ...], tuple[str, ...], Callable[[Case], Any]]
SRSS: Combining = (), ("factors",), lambda case: srss(*case.design)
ABS: Combining = (), ("factors",), lambda case: abs_sum(*case.design)

_RULES = (
    Rule("abs", "sum of the peaks (ABS)", "no code", None, "d1 + d2", DERIVED,
         "the triangle inequality: a bound in every motion of one ground", *ABS),
    Rule("srss", "square root of the sum of squares (SRSS)", "no code", None, "√(d1² + d2²)", DERIVED,
         "the variance of the difference of two independent motions", *SRSS),
    Rule("cqc", "double difference (DDC, CQC)", "Jeng, Kasai and Maison (1992)", 1992,
         "√(d1² + d2² − 2 ρ d1 d2), ρ the correlation under white noise", DERIVED,
         "Earthquake Spectra 8(2); exact for white noise (Der Kiureghian 1981), tested by Lyapunov's equation and "
         "noise", (), ("factors",), lambda case: cqc(case.design, case.periods, case.dampings), has_periods=True),
    Rule("asce7", "ASCE 7, same property", "ASCE/SEI 7-10, 12.12.3", 2010, "√(δM1² + δM2²), δM = Cd δmax / Ie", READ,
         "a public copy of the page, eqs. 12.12-1 and 12.12-2", *SRSS, superseded="ASCE/SEI 7-16 and 7-22", **ASCE7),
    Rule("asce7_boundary", "ASCE 7, across a property line", "ASCE/SEI 7-10, 12.12.3", 2010,
         "δM1 + δM2: each set back by its own δM", QUOTED,
         f"{IBC_TEXT}, with which the readable part of ASCE 7-10's agrees", *ABS,
         superseded="ASCE/SEI 7-16 and 7-22", **ASCE7),
    Rule("asce7_2016", "ASCE 7-16, same property", "ASCE/SEI 7-16, 12.12.3", 2016, "√(δM1² + δM2²), δM = Cd δmax / Ie",
         MEMORY, "", *SRSS, superseded="ASCE/SEI 7-22", **ASCE7),
    Rule("asce7_2016_boundary", "ASCE 7-16, across a property line", "ASCE/SEI 7-16, 12.12.3", 2016,
         "δM1 + δM2: each set back by its own δM", QUOTED, "by an engineer (theenvelope.co, Envelope 33)", *ABS,
         superseded="ASCE/SEI 7-22", **ASCE7),
    Rule("asce7_2022", "ASCE 7-22, same property", "ASCE/SEI 7-22, 12.12", 2022,
         "√(δM1² + δM2²), taken as in 7-16: the displacements of 12.8.6 were rewritten, read which one the clause "
         "means", MEMORY, "", *SRSS, **ASCE7_2022),
    Rule("asce7_2022_boundary", "ASCE 7-22, across a property line", "ASCE/SEI 7-22, 12.12", 2022,
         "δM1 + δM2, taken as in 7-16: the displacements of 12.8.6 were rewritten, read which one the clause means",
         MEMORY, "", *ABS, **ASCE7_2022),
    Rule("ubc97", "UBC 97, same property", "UBC 97, 1633.2.11", 1997, "√(ΔM1² + ΔM2²), ΔM = 0.7 R ΔS", QUOTED,
         f"by engineers, with its numbers (seaintarchive.org 2001, eng-tips.com 392487), and {IBC_TEXT}",
         (), ("factors",), lambda case: 0.7 * srss(*case.design), **UBC97),
    Rule("ubc97_boundary", "UBC 97, across a property line", "UBC 97, 1633.2.11", 1997,
         "ΔM1 + ΔM2, ΔM = 0.7 R ΔS: each set back by its own ΔM", QUOTED, "by an engineer (seaintarchive.org, 2001)",
         (), ("factors",), lambda case: 0.7 * abs_sum(*case.design), **UBC97),
    Rule("eurocode8", "Eurocode 8, same property", "EN 1998-1:2004, 4.4.2.7", 2004,
         "√(ds1² + ds2²), ds = qd de; times 0.7 where floors are at the same levels", MEMORY, "",
         (), ("factors", "aligned"), lambda case: _eurocode8_factor(case) * srss(*case.design), **EUROCODE8),
    Rule("eurocode8_boundary", "Eurocode 8, across a property line", "EN 1998-1:2004, 4.4.2.7", 2004,
         "ds1 + ds2: each at least ds from the line; times 0.7 where floors are at the same levels", MEMORY, "",
         (), ("factors", "aligned"), lambda case: _eurocode8_factor(case) * abs_sum(*case.design), **EUROCODE8),
    Rule("nbcc", "Canada", "NBC 2010, 4.1.8.14 (1)", 2010, "√(Δ1² + Δ2²), or the two are connected", QUOTED,
         "the Ontario Building Code (buildingcode.online/707.html), with the intent statement of NBC 2010", *SRSS,
         superseded="NBC 2015 and 2020", factor="Rd Ro / IE", level="2 % in 50 years (2475 years)",
         in_force="what the province has adopted"),
    Rule("mexico", "Mexico City", "NTC-Sismo 2004, 1.10", 2004,
         "sum of max(50 mm, d + 0.001, 0.003 or 0.006 h) in zone I, II or III; half of it for buildings alike", READ,
         "a public copy of the page", ("heights", "zone"), ("factors", "alike"),
         lambda case: _mexico(case, {"I": 0.001, "II": 0.003, "III": 0.006}, case.design),
         superseded="NTC-Sismo 2017 and later ones", factor="Q", level="the design spectrum of the code"),
    Rule("mexico_simplified", "Mexico City, simplified analysis", "NTC-Sismo 2004, 1.10", 2004,
         "sum of max(50 mm, 0.007, 0.009 or 0.012 h) in zone I, II or III; half of it for buildings alike", READ,
         "a public copy of the page", ("heights", "zone"), ("alike",),
         lambda case: _mexico(case, {"I": 0.007, "II": 0.009, "III": 0.012}, (0.0, 0.0)),
         superseded="NTC-Sismo 2017 and later ones", level="the design spectrum of the code, by height alone"),
    Rule("china", "China, reinforced concrete", "GB 50011-2010, 6.1.4", 2010,
         "100 mm to 15 m of the lower height h, then 20 mm more for each 5, 4, 3 or 2 m in intensity 6, 7, 8 or 9, in "
         "proportion; frames with walls 70 %, walls 50 %, never below 100 mm", QUOTED,
         "in full, in examination answers (kaowang.cn 1954275 and 2364995)",
         ("heights", "intensity"), ("structure",), _china, superseded="its revisions of 2016 and 2024",
         level="intensity of fortification (475 years), by height alone"),
    Rule("is1893_2002", "India, 2002", "IS 1893 (Part 1):2002, 7.11.3", 2002,
         "R (Δ1 + Δ2); R / 2 instead of R and 25 mm more where floors are at the same levels", MEMORY, "",
         (), ("factors", "aligned"),
         lambda case: abs_sum(*case.design) * 0.5 + 0.025 if case.site.aligned else abs_sum(*case.design),
         superseded="IS 1893 (Part 1):2016", factor="R",
         level="design basis, half of the maximum considered (zone factor Z / 2)"),
    Rule("is1893_2016", "India, 2016", "IS 1893 (Part 1):2016, 7.11.3", 2016, "R1 Δ1 + R2 Δ2", MEMORY, "", *ABS,
         factor="R", level="design basis, half of the maximum considered (zone factor Z / 2)", in_force=INDIA),
    Rule("peru", "Peru", "E.030", 2018, "largest of 0.006 h, 30 mm and 2/3 (d1 + d2)", MEMORY, "", ("heights",),
         ("factors",), lambda case: np.maximum(max(0.03, 0.006 * case.lower), abs_sum(*case.design) * 2.0 / 3.0),
         factor="0.75 R, irregular 0.85 R", level="10 % in 50 years (475 years)"),
    Rule("iran", "Iran, to 8 storeys", "Standard 2800, 4th edition", 2014,
         "0.005 h1 + 0.005 h2: each storey set back by 0.005 of its height; at the level of the lower roof", MEMORY, "",
         ("heights",), (), lambda case: 0.01 * case.lower, level="10 % in 50 years (475 years), by height alone"),
    Rule("turkey", "Turkey", "TBDY 2018, seismic joints", 2018,
         "α √(Δ1² + Δ2²), α = 0.5 R / I, 0.25 R / I where floors are at the same levels; at least 30 mm to 6 m of "
         "height and 10 mm more for each 3 m, in proportion", QUOTED,
         "the conditions in full (insapedia.com, deprem derzleri)", ("heights",), ("factors", "aligned"), _turkey,
         factor="R / I", level="DD-2: 10 % in 50 years (475 years)"),
    Rule("italy", "Italy", "NTC 2008, 7.2.2", 2008, "d1 + d2, and at least h / 100 · ag S / 0.5 g", QUOTED,
         "in full (risponde.promolegno.com 11764)", ("heights", "ground"), ("factors",),
         lambda case: np.maximum(abs_sum(*case.design), 0.01 * case.lower * (case.site.ground or 0.0) / HALF_GRAVITY),
         superseded="NTC 2018", factor="μd of 7.3.3.3",
         level="SLV: 10 % in the reference life, 475 years where that is 50"),
    Rule("italy_2018", "Italy, 2018", "NTC 2018, 7.2.1", 2018,
         "d1 + d2, and at least h / 100 · 2 ag S / g, that factor at most 1", MEMORY, "",
         ("heights", "ground"), ("factors",),
         lambda case: np.maximum(abs_sum(*case.design),
                                 0.01 * case.lower * min((case.site.ground or 0.0) / HALF_GRAVITY, 1.0)),
         factor="μd of 7.3.3.3", level="SLV: 10 % in the reference life, 475 years where that is 50"),
    Rule("nzs1170", "New Zealand, across a boundary", "NZS 1170.5:2004, section 7", 2004,
         "δ1 + δ2: each stays on its own side, δ the design deflection of the ultimate limit state", MEMORY, "", *ABS,
         factor="μ", level="ultimate limit state, 500 years for importance level 2"),
    Rule("taiwan", "Taiwan", "Seismic design code for buildings, edition of 2011", 2011,
         "0.6 · 1.4 αy Ra (d1 + d2): each set back by its own", MEMORY, "",
         (), ("factors",), lambda case: 0.6 * abs_sum(*case.design), superseded="the edition of 2022",
         factor="1.4 αy Ra", level="design earthquake, 10 % in 50 years (475 years)",
         in_force="the edition of 2022, since October of that year as narlabs.org.tw reports; its clause was not seen"),
    Rule("asce41", "ASCE 41, existing buildings", "ASCE/SEI 41-13, 7.2.13", 2013,
         "√(Δ1² + Δ2²), which need not exceed 4 % of the height where contact is possible", MEMORY, "",
         ("heights",), ("factors",), _asce41, superseded="ASCE/SEI 41-17 and 41-23",
         factor="1: of the linear procedure's pseudo-lateral force", level="hazard level of the performance objective"),
)  # fmt: skip


def _checked_rule(name: str, rule: Any) -> Rule:
    """The rule that a plug-in names; raises PoundingError for what is none."""
    if not isinstance(rule, Rule) or rule.name != name or rule.verification not in VERIFICATIONS:
        raise PoundingError(f'it is not a Rule with the name "{name}" and one of the verifications {VERIFICATIONS}')
    return rule


RULES = Registry("rules", {rule.name: rule for rule in _RULES}, _checked_rule)
COMBINATIONS = tuple(rule.name for rule in _RULES if rule.verification == DERIVED)

# What a rule took for granted, where the user said nothing else.
TAKEN = {
    "factors": "d is that of the linear model, not reduced (factors 1)",
    "aligned": "floors not at the same levels",
    "alike": "buildings not alike",
    "structure": "frames",
}
# What a rule's number is where the displacements are those of a dataset's own motions.
OWN_PEAKS = "from these motions' own peaks; not the code's design displacement"
SUPERSEDED = (
    "Superseded means that a later edition is published; which one is in force is decided by the authority of the site"
)
# What a required gap below a rule's rests on; read in the text named, its edition and adoption not known here.
RATIONAL = (
    "A gap below a rule's rests on an exception such as that of the International Building Code on separations (read "
    "at up.codes/s/building-separations, beside eq. 16-64; section 1620.4.5 in the edition of 2003, csengineermag.com "
    "says): smaller separations and setbacks are allowed where rational analyses for the maximum expected ground "
    "motions justify them. Check whether the code in force on the site has it, and for which motions"
)
# Notes that many rows share, and the sentence that says the same once below a table.
FROM_MEMORY, QUOTED_ONLY = "clause from memory, not read", "clause quoted by others, not read"
NOT_REDUCED = TAKEN["factors"]
OF_HISTORIES = "d is the peak of a displacement_history, where a building has one, not reduced (factors 1)"
OF_YIELDING = "d is the peak of a model whose storeys or isolators may yield, not reduced (factors 1)"
# UBC 97, 1630.9.2, exception (from memory): ΔM may be that of a nonlinear time history.
OF_UBC97 = (
    "0.7 R ΔS is ΔM of an elastic analysis; of peaks of a model that yields ΔM is not reduced (1630.9.2, from memory): "
    "the rule then requires 1 / 0.7 of this value"
)
ONE_GROUND = "the ground under both is taken to move alike"
ROTATING = "displacements are those of the centres of mass: edges of floors that rotate move further"
ISOLATED = "the period of an isolated building is that before its isolators yield"
CLEAR = "separations and gaps needed are clear of the bumpers, whose length comes on top"
MOAT = "not for the moat of an isolated building"
SHARED = {
    MOAT: (
        "These rules are for ordinary buildings; those for the moat of an isolated one are in ASCE/SEI 7, chapter 17 "
        "(its total maximum displacement D_TM), and EN 1998-1, section 10 (from memory, not read)"
    ),
    FROM_MEMORY: "Rules from memory were not read anywhere: read the clause before relying on one",
    QUOTED_ONLY: "Quoted rules were read in texts that quote the clause or take it over, not in the code itself",
    NOT_REDUCED: "Displacements are those of the linear model: a code's C_d / R, q_d / q and the like are taken as 1",
    OF_YIELDING: "Displacements are the peaks of models whose storeys or isolators may yield; factors are taken as 1",
    OF_HISTORIES: "Displacements are the peaks of a displacement_history, or of a linear model; factors are taken as 1",
    ONE_GROUND: "The ground under both is taken to move alike: that it does not is in the gap needed, and in no rule",
}
