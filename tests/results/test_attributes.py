"""Attributes of datasets: versions of libraries."""

from importlib import metadata

from pounding_risk.results.attributes import LIBRARIES, LINEAR_OF_LINKS, has_laws_of_links, versions, versions_of
from pounding_risk.scene.sections import KEYS


def test_versions_are_those_that_python_tells():
    """They are read from the first lines of the metadata, without the manual that follows."""
    told = versions()
    assert {name: told[name] for name in LIBRARIES} == {name: metadata.version(name) for name in LIBRARIES}


def test_what_is_not_installed_is_told():
    assert versions_of(["numpy", "no-such-package"]) == {
        "numpy": metadata.version("numpy"),
        "no-such-package": "not installed",
    }


def test_a_link_is_linear_by_the_keys_that_are_known_to_be():
    """Any other counts as a law, so that a key that is added is never scaled with the motion by oversight."""
    of_links = [key for key in KEYS["interface"] if key.startswith("link_")]
    assert set(of_links) > LINEAR_OF_LINKS
    for key in (*of_links, "gap"):
        for scene in ({"interface": [{key: 1.0}]}, {"grid": {f"interface.1.{key}": [1.0]}}):
            assert has_laws_of_links(scene) == (key in of_links and key not in LINEAR_OF_LINKS), key
