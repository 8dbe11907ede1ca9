"""The names of `pounding_risk.motions`: found, imported late, with documented parameters and right examples."""

from __future__ import annotations

import subprocess
import sys

import pytest
from numpydoc.validate import validate

from pounding_risk import motions

# A docstring, every parameter described under its name and no other, what is returned.
CHECKS = {"GL08", "PR01", "PR02", "PR03", "PR07", "RT01", "RT03", "YD01"}


@pytest.mark.parametrize("name", motions.__all__)
def test_a_public_name_is_documented(name):
    public = getattr(motions, name)
    errors = validate(f"{public.__module__}.{public.__qualname__}")["errors"]
    assert [f"{code}: {sentence}" for code, sentence in errors if code in CHECKS] == []


def test_other_names_are_refused():
    assert set(motions.__all__) <= set(dir(motions))
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        motions.nothing  # noqa: B018 (the look-up is what is tested)


def test_importing_the_namespace_imports_no_library():
    code = "import sys, pounding_risk.motions; print(sorted({'numpy', 'obspy', 'numba', 'scipy'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"
