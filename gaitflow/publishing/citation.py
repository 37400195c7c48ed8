"""How to cite what is published: the paper that is implemented, and the software."""

from __future__ import annotations

import gaitflow

LICENCE = "BSD-3-Clause"
LICENCE_ADDRESS = "https://spdx.org/licenses/BSD-3-Clause.html"
MAINTAINERS = "The gaitflow maintainers"

PAPER = """@inproceedings{wang2020automatic,
  title = {Automatic Gait Pattern Selection for Legged Robots},
  author = {Wang, Jiayi and Chatzinikolaidis, Iordanis and Mastalli, Carlos and Wolfslag, Wouter and Xin, Guiyang and
            Tonneau, Steve and Vijayakumar, Sethu},
  booktitle = {2020 IEEE/RSJ International Conference on Intelligent Robots and Systems (IROS)},
  year = {2020}
}"""


def software() -> str:
    """The software as BibTeX."""
    return f"""@software{{gaitflow,
  title = {{gaitflow}},
  author = {{{{{MAINTAINERS}}}}},
  version = {{{gaitflow.__version__}}},
  license = {{{LICENCE}}}
}}"""


def dataset(name: str, version: str, year: str) -> str:
    """A dataset's version as BibTeX."""
    return f"""@misc{{{name}-{version},
  title = {{{name} {version}: solved gaits and labels}},
  author = {{{{{MAINTAINERS}}}}},
  year = {{{year}}},
  version = {{{version}}}
}}"""
