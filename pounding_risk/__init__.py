"""Seismic pounding of adjacent buildings: from strong-motion records to an assessment of gaps.

Every command of the command line is one function here, under the same name. Namespaces for the rest are `figures`,
`laws` (of contact), `motions`, `streets`, `studies` and `units`. All are imported on first use, so that
``import pounding_risk`` costs next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

_HOMES = {
    "__version__": "_common.version",
    "demo": "reports.demo",
    "export": "reports.exports",
    "validate": "ensemble.plan.plan",
    "impact": "studies.impact",
    "contact_law": "models.contact.register",
    "simulate": "studies.simulate",
    "scan": "ensemble.scan",
    "scan_shard": "ensemble.scan",
    "Dask": "ensemble.dask",
    "rerun": "questions.rerun",
    "histories": "studies.histories",
    "compare": "studies.compare",
    "advise": "studies.advice",
    "accuracy": "lab.accuracy",
    "stability": "lab.stability",
    "verify": "lab.verification",
    "effects": "lab.effects",
    "modes": "studies.modes",
    "PoundingError": "errors",
    "Stopped": "errors",
    "read_scene": "scene.reader",
    "schema": "scene.sections",
    "Scene": "scene.scene",
    "SingleMass": "scene.buildings",
    "ShearBuilding": "scene.buildings",
    "TypologyBuilding": "scene.buildings",
    "MatrixBuilding": "scene.matrix_buildings",
    "ModalBuilding": "scene.matrix_buildings",
    "RigidWall": "scene.buildings",
    "Isolation": "scene.building_tables",
    "Interface": "scene.interfaces",
    "EqualTerms": "scene.interfaces",
    "Records": "scene.records",
    "Grid": "scene.tables",
    "Uncertain": "scene.uncertain_tables",
    "sample_axis": "scene.uncertain",
    "Solver": "scene.tables",
    "Effect": "scene.tables",
    "DamageState": "scene.damage",
    "read_motion": "motions.read",
    "generate_motion": "motions.read",
    "code_table": "assessment.separations.table",
    "separations": "assessment.separations.table",
    "Site": "assessment.separations.rules",
    "spectra": "questions.spectra",
    "amplification": "questions.amplification",
    "assess": "assessment.assess",
    "uncertainty": "questions.uncertainty",
    "setbacks": "questions.setback",
    "assess_along": "assessment.along",
    "damage": "questions.damage",
    "row_case": "assessment.row",
    "view": "reports.explorer",
    "report": "reports",
    "draw": "reports.drawings",
    "animate": "reports.animation",
    "block": "streets.rows",
    "read_block": "streets.rows",
    "status": "ensemble.status",
    "cache": "studies.cache",
    "convert": "studies.convert",
    "summary": "results.summary",
    "open_results": "results.files",
    "save": "results.files",
}

_NAMESPACES = {
    "figures": "figures",
    "laws": "models.contact.laws",
    "motions": "motions",
    "streets": "streets",
    "studies": "studies",
    "units": "units",
}

__all__ = [*_HOMES]


def __getattr__(name: str) -> Any:
    if name in _NAMESPACES:
        value: Any = import_module(f"{__name__}.{_NAMESPACES[name]}")
    elif name in _HOMES:
        value = getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)
    else:
        value = _question(name)
    globals()[name] = value
    return value


def _question(name: str) -> Any:
    """The function of a question that stands in `questions` alone."""
    if not name.startswith("_"):
        questions = import_module(f"{__name__}.questions").declared_questions()
        if name in questions:
            return questions[name].function()
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_NAMESPACES])
