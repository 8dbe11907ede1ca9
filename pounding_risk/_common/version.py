"""The version of this package, which the metadata of its installation states: the tag that it was built from."""

from __future__ import annotations

from importlib import metadata

try:
    __version__ = metadata.version("pounding-risk")
except metadata.PackageNotFoundError:  # source that runs without being installed
    __version__ = "0+unknown"
