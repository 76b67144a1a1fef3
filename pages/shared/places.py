"""Name the pages in the order of the navigation, and where an address of earlier versions leads today."""

from __future__ import annotations

from pathlib import Path

PAGES = Path(__file__).resolve().parents[1]
START, *EVERY = sorted(PAGES.glob("[0-9]*_*.py"), key=lambda path: int(path.stem.partition("_")[0]))
STEPS = [path for path in EVERY if path.stem[1] == "_"]  # of a job, in their order
CUSTOMER = "/customer"  # before the token of a screen
MOVED = {  # by the name in an address of before: where it leads
    "Readings": "Measure",
    **dict.fromkeys(("Pressures", "Road_test"), "In_the_car"),
    "Uncertainty": "Diagnosis?diagnosis=lands",
    "What_if": "Plan?plan=what_if",
    "Estimate": "Plan?plan=repairs",
    "Job_book": "Jobs",
    "Unit": "History?history=unit",
    "Compare": "History?history=compare",
    **{
        name: f"Library?library={name.lower()}"
        for name in ("Catalogue", "Transmission", "Workshop_data", "Gauge_study")
    },
    "Source_study": "Library?library=catalogue",
}


def name_of(path: Path) -> str:
    """Return the name of a page in its address and in the texts."""
    return path.stem.partition("_")[2]


def page(name: str) -> Path:
    """Return the script of a page, by its name in an address."""
    return next((path for path in EVERY if name_of(path) == name), START)


def moved(name: str, query: str) -> str:
    """Return where the address of a page of before leads, with what was asked of that."""
    return f"{MOVED[name]}{'&' if '?' in MOVED[name] else '?'}{query}".rstrip("?&")
