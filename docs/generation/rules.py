"""The page of code separations, from their registry."""

from __future__ import annotations

from generation.markdown import docstring, plain, table
from pounding_risk.assessment.separations import rules as separation_rules
from pounding_risk.assessment.separations.rules import RATIONAL, RULES, SUPERSEDED

RULES_HEAD = """# Separation rules

What a code asks for between two buildings, as data. `pounding-risk separations` prints this list, and with a dataset
sets each rule beside the gaps that the motions need. **Rules marked from memory were not read anywhere, quoted ones in
texts that quote the clause or take it over: read the clause before you rely on one.**

"""


def rules_page() -> str:
    """Every rule: clause, year, how its text is known, later editions, formula."""
    heads = ("rule", "clause", "year", "text", "superseded by", "separation")
    rows = [
        (
            f"`{rule.name}`",
            plain(f"{rule.title}; {rule.clause}"),
            "" if rule.year is None else str(rule.year),
            rule.verification if rule.is_checked else f"**{rule.verification}**",
            plain(rule.superseded),
            plain(f"{rule.formula}{_needs(rule.needs)}"),
        )
        for rule in RULES.values()
    ]
    sources = [(f"`{rule.name}`", rule.verification, plain(rule.source)) for rule in RULES.values() if rule.source]
    in_force = [(f"`{rule.name}`", plain(rule.in_force)) for rule in RULES.values() if rule.in_force]
    levels = [(f"`{rule.name}`", plain(rule.level), plain(rule.factor)) for rule in RULES.values() if rule.level]
    about = (separation_rules.__doc__ or "").partition("\n\n")[2]
    return (
        f"{RULES_HEAD}{table(heads, rows)}\n## The texts\n\n{table(('rule', 'text', 'by'), sources)}\n"
        f"## In force\n\n{SUPERSEDED}.\n\n{table(('rule', 'in force'), in_force)}\n"
        f"## Ground motion and factor, from memory\n\n"
        f"{table(('rule', 'ground motion of the clause', 'factor of elastic design displacements'), levels)}\n"
        f"## Rational analyses\n\n{RATIONAL}.\n\n"
        f"## What they work with\n\n{docstring(about)}"
    )


def _needs(needs: tuple[str, ...]) -> str:
    return f"; needs {' and '.join(needs)}" if needs else ""
