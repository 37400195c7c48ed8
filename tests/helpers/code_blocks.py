"""The code blocks of a page: fences say their language, indented ones hold shell lines."""

from __future__ import annotations

import re
from dataclasses import dataclass
from textwrap import dedent

FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)((?: {4}.*\n|\n(?= {4}))+)")


@dataclass(frozen=True)
class Block:
    """Code in a language, "" where a fence names none."""

    language: str
    code: str


def blocks_of(page: str) -> tuple[Block, ...]:
    """The blocks of a page's text, from its top to its end."""
    found = [(match.start(), Block(match[2], dedent(match[3]))) for match in FENCE.finditer(page)]
    prose = FENCE.sub(lambda match: re.sub(r"[^\n]", "-", match[0]), page)
    found += [(match.start(), Block("bash", dedent(match[1]))) for match in INDENTED.finditer(prose)]
    return tuple(block for _, block in sorted(found, key=lambda each: each[0]))


def code_of(page: str, language: str) -> list[str]:
    """The code of a page's blocks in a language."""
    return [block.code for block in blocks_of(page) if block.language == language]


def shell_lines(page: str) -> list[str]:
    """The lines of a page's shell blocks; one that goes on after a backslash is one line."""
    code = "\n".join(code_of(page, "bash")).replace("\\\n", " ")
    return [line for line in code.splitlines() if line.strip()]
