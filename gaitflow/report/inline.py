"""Scripts and styles inside an HTML file that loads nothing from elsewhere, named in its content security policy."""

from __future__ import annotations

import base64
import hashlib
from importlib.resources import files


def packaged(name: str) -> str:
    """The text of a file of this package, such as a script."""
    return files("gaitflow.report").joinpath(name).read_text(encoding="utf-8")


def policy(script: str, style: str) -> str:
    """A content security policy under which this script and this style run, and nothing else does."""
    return f"default-src 'none'; script-src '{_digest(script)}'; style-src '{_digest(style)}'"


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
