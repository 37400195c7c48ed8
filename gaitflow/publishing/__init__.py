"""The versioned artifact `models/<scenario>/<version>/`: publish it, verify it, list its versions."""

from gaitflow.publishing.parts import Parts, PublishError, RegionStart, runtime_layout
from gaitflow.publishing.publish import VersionExists, publish
from gaitflow.publishing.verify import Finding, verify
from gaitflow.publishing.versions import Published, newest, published

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
    "runtime_layout",
    "verify",
]
