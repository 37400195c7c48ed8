"""The versioned artifact `models/<scenario>/<version>/`: publish it, verify it, list its versions."""

from gaitflow.artifact.parts import Parts, PublishError, RegionStart, runtime_layout
from gaitflow.artifact.publish import VersionExists, publish
from gaitflow.artifact.verify import Finding, verify
from gaitflow.artifact.versions import Published, newest, published

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
