"""Print pip constraints that hold every dependency at the lowest version that pyproject.toml declares.

``python tools/lowest_versions.py > lowest.txt && python -m pip install -c lowest.txt ".[test]"``
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections.abc import Iterable
from pathlib import Path

PYPROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"

#: Extras that no program at run time and no test needs.
LEFT_OUT = ("docs",)

#: ``name[extra]>=1.2,<2``: the name and the lower bound.
_REQUIREMENT = re.compile(r"^(?P<name>[\w.-]+)(?:\[[\w,]+\])?\s*>=\s*(?P<lowest>[\w.]+)")


def lowest(requirements: Iterable[str]) -> dict[str, str]:
    """Return the lowest version that requirements allow, by the dependency's name.

    Raises ``ValueError`` for a requirement without a lower bound, and for two lower bounds of one dependency.

    >>> lowest(["numpy>=1.26", "psycopg[binary]>=3.1.18", "segno>=1.5,<2"])
    {'numpy': '1.26', 'psycopg': '3.1.18', 'segno': '1.5'}
    """
    found: dict[str, str] = {}
    for requirement in requirements:
        match = _REQUIREMENT.match(requirement)
        if match is None:
            raise ValueError(f"{requirement!r} has no lower bound")
        name, version = match["name"], match["lowest"]
        if found.setdefault(name, version) != version:
            raise ValueError(f"{name} has two lower bounds: {found[name]} and {version}")
    return found


def declared() -> list[str]:
    """Return the requirements of the package and of its extras as pyproject.toml declares them."""
    project = tomllib.loads(PYPROJECT.read_text(encoding="utf-8"))["project"]
    extras = [extra for name, extra in project["optional-dependencies"].items() if name not in LEFT_OUT]
    return [*project["dependencies"], *(requirement for extra in extras for requirement in extra)]


def main() -> int:
    for name, version in lowest(declared()).items():
        print(f"{name}=={version}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
