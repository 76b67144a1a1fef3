"""Say which tables describe a valve body, step by step, and draw those of one step."""

from __future__ import annotations

from atleak.catalogue.pump_reading import other_dimensions
from atleak.views.entry_form import Checked
from pages.shared import entry_tables
from pages.shared.editing import Editing

COMPONENTS, NEW_PARTS, PUMP = "components", "new_parts", "pump"
STEPS = {
    "head": ("Head",),
    COMPONENTS: ("Components", "Lands", "Materials"),
    NEW_PARTS: (),  # no tables of its own: sheets of new units, from which mounting clearances are learned
    PUMP: ("Pump",),
    "points": ("Operating points",),
    "circuits": ("Circuits", "Feeds", "Set pressures", "Apply chart"),
    "gaps": ("Gaps", "Section pressures"),
    "pressures": ("Line pressures",),
    "leaks": ("Leaks", "Consumers", "Consumer flows"),
    "repairs": ("Repairs", "Complaints"),
}


def draw(editing: Editing, step: str, found: Checked) -> None:
    """Draw the tables and fields of a step; a pump's dimensions of other kinds in a fold."""
    kind = found.data.get("pump", {}).get("kind")
    entry_tables.draw(editing, STEPS[step], found, frozenset(other_dimensions(kind)) if step == PUMP else ())
