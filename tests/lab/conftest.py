"""All published cases and properties, run once for the tests that read them."""

from __future__ import annotations

import pytest

import pounding_risk as pr


@pytest.fixture(scope="session")
def outcome():
    """What `pounding-risk verify` finds."""
    return pr.verify()
