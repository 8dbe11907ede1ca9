"""All published cases and properties, run once for tests that read them; what takes long is of the complete tests."""

from __future__ import annotations

from pathlib import Path

import pytest

import pounding_risk as pr

LONG = {"outcome", "of_row", "found"}  # fixtures: all that ships, accuracy and effects of rows, all effects


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what asks for a long fixture."""
    here = Path(__file__).parent
    for item in items:
        if item.path.is_relative_to(here) and LONG & set(getattr(item, "fixturenames", ())):
            item.add_marker("complete")


@pytest.fixture(scope="session")
def outcome():
    """What `pounding-risk verify` finds."""
    return pr.verify()
