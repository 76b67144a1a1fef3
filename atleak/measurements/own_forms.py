"""The forms that atleak writes to be filled in: by which mark each is known again, and the headings of its columns.

`atleak.report.sheets` writes them and `atleak.readers.own_forms` reads them: both ask here. A mark is the text of one
cell, which every spreadsheet program keeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from atleak.common.sentences import Sentence
from atleak.measurements.gauge_readings import Engine

BEGINNING = "atleak form"  # of every mark
MOST_REPEATS = 9  # of a measuring sheet that have headings of their own
ATF_TEMPERATURE = Sentence("ATF temperature")  # above the gauge readings


@dataclass(frozen=True)
class OwnForm:
    """A form, or a tab of one.

    Parameters
    ----------
    mark
        the text of the cell that tells it.
    headings
        by what a column holds; a unit stands behind it in square brackets.
    needed
        what columns must hold for anything to be read, of whichever repeat.
    """

    mark: str
    headings: Mapping[str, str]
    needed: tuple[str, ...] = ()


_KEYS = {
    "component": Sentence("No."),
    "part": Sentence("Part"),
    "plane": Sentence("Plane"),
    "direction": Sentence("Direction"),
    "repeat": Sentence("Repeat"),
}
_OF_REPEAT = {
    "coordinate 1": Sentence("x1 (y1) {repeat}"),
    "coordinate 2": Sentence("x2 (y2) {repeat}"),
    "diameter": Sentence("Diameter {repeat}"),
    "deviation": Sentence("Deviation {repeat}\nfrom nominal"),
}
REPEATED: Mapping[str, tuple[str, int]] = {
    f"{holds}, repeat {repeat}": (holds, repeat) for repeat in range(1, MOST_REPEATS + 1) for holds in _OF_REPEAT
}  # what a column holds and of which repeat, by the key of its heading
_OF_READINGS = ("component", "part", "plane", "diameter")
MEASUREMENTS = OwnForm(  # its repeats side by side; or, as before, a row for each
    f"{BEGINNING}: measurements",
    {
        **_KEYS,
        "name": Sentence("Component"),
        "coordinate 1": Sentence("Coordinate\nx1 (y1)"),
        "coordinate 2": Sentence("Coordinate\nx2 (y2)"),
        "diameter": Sentence("Diameter"),
        "nominal": Sentence("Nominal\ndiameter"),
        "clearance": Sentence("Mounting\nclearance"),
        "origin": Sentence("Nominal values\nare"),
        "deviation": Sentence("Deviation from\nnominal"),
        "taken at": Sentence("Taken at"),
        **{key: _OF_REPEAT[holds].of(repeat=repeat) for key, (holds, repeat) in REPEATED.items()},
    },
    _OF_READINGS,
)
TYPED = OwnForm(  # at the bench: the sheet may hold nothing yet that counts
    "atleak: readings typed in",
    {
        **{key: str(heading) for key, heading in _KEYS.items()},
        "coordinate 1": "Coordinate x1",
        "coordinate 2": "Coordinate x2",
        "diameter": "Diameter",
        "counts": "Counts",
        "taken at": "Taken at",
    },
    _OF_READINGS,
)
LANDS = OwnForm(
    f"{BEGINNING}: lands",
    {
        "component": Sentence("No."),
        "name": Sentence("Component"),
        "land": Sentence("Land"),
        "contact length": Sentence("Contact\nlength"),
        "stated length": Sentence("Stated contact\nlength"),
        "position": Sentence("Position from\nleft end"),
        "stated position": Sentence("Stated length from\nleft end"),
        "note": Sentence("Note"),
        "fitted repair": Sentence("Fitted repair"),
        "note on repairs": Sentence("Note on repairs"),
    },
    ("component", "land", "contact length", "position"),
)
PRESSURES = OwnForm(
    f"{BEGINNING}: pressures",
    {
        "range": Sentence("Range"),
        "tap": Sentence("Tap"),
        **{engine.value: engine.label for engine in Engine},
        **{
            f"permissible {engine.value}": Sentence("Permissible at {engine}", engine=engine.label) for engine in Engine
        },
    },
    ("range", "tap", *(engine.value for engine in Engine)),
)
GAUGES = OwnForm(
    f"{BEGINNING}: gauge readings",
    {
        "range": "range",
        "engine": "state",
        "tap": "tap",
        "value": "gauge",
        "temperature": "ATF temperature",
        "engine_speed": "engine speed",
    },
    ("range", "engine", "tap", "value"),
)
FLOWS = OwnForm(
    f"{BEGINNING}: flows", {"condition": "condition", "what": "what", "value": "value"}, ("condition", "what", "value")
)
VACUUM = OwnForm(
    f"{BEGINNING}: vacuum test",
    {"target": "circuit or land", "reading": "reading", "state": "state"},
    ("target", "reading", "state"),
)
STUDY = OwnForm(
    f"{BEGINNING}: gauge study",
    {
        "part": Sentence("Part"),
        "operator": Sentence("Operator"),
        "trial": Sentence("Trial"),
        "reading": Sentence("Reading"),
    },
    ("part", "operator", "trial", "reading"),
)
INSTRUCTIONS = OwnForm(f"{BEGINNING}: how to measure", {})
OWN_FORMS: Mapping[str, OwnForm] = {
    form.mark: form for form in (MEASUREMENTS, TYPED, LANDS, PRESSURES, GAUGES, FLOWS, VACUUM, STUDY, INSTRUCTIONS)
}
