"""Attributes of datasets: versions of libraries."""

from __future__ import annotations

from importlib import metadata

from pounding_risk.results.attributes import LIBRARIES, versions, versions_of


def test_versions_are_those_that_python_tells():
    """They are read from the first lines of the metadata, without the manual that follows."""
    told = versions()
    assert {name: told[name] for name in LIBRARIES} == {name: metadata.version(name) for name in LIBRARIES}


def test_what_is_not_installed_is_told():
    assert versions_of(["numpy", "no-such-package"]) == {
        "numpy": metadata.version("numpy"),
        "no-such-package": "not installed",
    }
