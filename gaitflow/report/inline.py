"""Templates, scripts and styles of an HTML file that loads nothing, named in its content security policy."""

from __future__ import annotations

import base64
import hashlib
from importlib.resources import files

from jinja2 import Environment, FunctionLoader, StrictUndefined, Template


def packaged(name: str) -> str:
    """The text of a file of this package, such as a script."""
    return files("gaitflow.report").joinpath(name).read_text(encoding="utf-8")


def template(name: str) -> Template:
    """A template of this package, which escapes every text; data for scripts are written without blanks."""
    environment = Environment(autoescape=True, undefined=StrictUndefined, loader=FunctionLoader(packaged))
    environment.policies["json.dumps_kwargs"] = {"separators": (",", ":")}
    return environment.get_template(name)


def policy(script: str, style: str) -> str:
    """A content security policy under which this script and this style run, pictures inside the file are shown.

    Nothing else runs, and nothing is loaded.
    """
    return f"default-src 'none'; img-src data:; script-src '{_digest(script)}'; style-src '{_digest(style)}'"


def _digest(text: str) -> str:
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode("ascii")
