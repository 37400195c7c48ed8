"""Published folders, `models/<scenario>/<version>` and `datasets/<scenario>/<version>`: publish, verify, list."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gaitflow.publishing.parts import Parts, RegionStart
    from gaitflow.publishing.publish_map import publish
    from gaitflow.publishing.verify_map import verify
    from gaitflow.publishing.versioned_folder import Finding, PublishError, VersionExists
    from gaitflow.publishing.versions import Published, newest, published

_HOMES = {
    "Finding": "versioned_folder",
    "Parts": "parts",
    "PublishError": "versioned_folder",
    "Published": "versions",
    "RegionStart": "parts",
    "VersionExists": "versioned_folder",
    "newest": "versions",
    "publish": "publish_map",
    "published": "versions",
    "verify": "verify_map",
}

__all__ = [
    "Finding",
    "Parts",
    "PublishError",
    "Published",
    "RegionStart",
    "VersionExists",
    "newest",
    "publish",
    "published",
    "verify",
]


def __getattr__(name: str) -> Any:
    # A dataset is published and listed without what a map takes to build.
    if name in _HOMES:
        return getattr(import_module(f"gaitflow.publishing.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
