"""The version of this package, which the metadata of its installation states: the tag that it was built from."""

from __future__ import annotations

from importlib import metadata

UNKNOWN = "0+unknown"


def installed_version() -> str:
    """The version of the installed distribution; `UNKNOWN` of source that runs without being installed."""
    try:
        return metadata.version("pounding-risk")
    except metadata.PackageNotFoundError:
        return UNKNOWN


__version__ = installed_version()
