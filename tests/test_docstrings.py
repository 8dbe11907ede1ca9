"""Docstrings of the public names have the sections of numpydoc, with the parameters of their signatures."""

import pytest
from numpydoc.validate import validate

import pounding_risk
from pounding_risk import figures, motions

# Of numpydoc's checks: a docstring, every parameter described under its name and no other, what is returned.
CHECKS = {"GL08", "PR01", "PR02", "PR03", "PR07", "RT01", "RT03", "YD01"}
PUBLIC = [getattr(pounding_risk, name) for name in pounding_risk.__all__ if name != "__version__"]
PUBLIC += [getattr(figures, name) for name in dir(figures) if name.endswith("_figure")]
PUBLIC += [getattr(motions, name) for name in motions.__all__ if getattr(motions, name) not in PUBLIC]


@pytest.mark.parametrize("public", PUBLIC, ids=lambda public: public.__qualname__)
def test_its_docstring_has_sections(public):
    found = validate(f"{public.__module__}.{public.__qualname__}")
    assert [f"{code}: {sentence}" for code, sentence in found["errors"] if code in CHECKS] == []
