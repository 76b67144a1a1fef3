"""The product's own code, read once for the tests that look into it."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


@cache
def nodes() -> dict[str, list[ast.AST]]:
    """Every node of the dashboard's and the package's modules, by the module's path from the root."""
    code = [ROOT / "app.py", *(ROOT / "pages").rglob("*.py"), *(ROOT / "atleak").rglob("*.py")]
    return {
        path.relative_to(ROOT).as_posix(): list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))) for path in code
    }
