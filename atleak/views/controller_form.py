"""The valve body as a subject that can be typed, and what of it can be drawn before it is complete."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_reading import CONTROLLERS, checked_controller
from atleak.controller_sheets.layout import NAMES, SHEETS
from atleak.errors import CatalogueError
from atleak.views.entry_form import Subject

CONTROLLER = Subject(CONTROLLERS, SHEETS, NAMES)
_LAND_KEYS = ("land", "nominal_diameter_mm", "contact_length_mm")  # what a drawing needs


def sketch(data: Mapping[str, Any]) -> Controller | None:
    """Return a controller with the components and lands that can be drawn so far; None without any.

    Nothing of it is for computing: all but sizes and names is made up.
    """
    components = {}
    length = data.get("defaults", {}).get("contact_length_mm")
    for table in data.get("components", ()):
        lands = {
            land["land"]: {"contact_length_mm": length or 5.0} | {key: land[key] for key in _LAND_KEYS if key in land}
            for land in table.get("lands", ())
            if "land" in land and "nominal_diameter_mm" in land
        }
        good = [land for land in lands.values() if _controller_of([{"id": "one", "name": "one", "lands": [land]}])]
        if "id" in table and good:
            components[table["id"]] = {"id": table["id"], "name": table.get("name", table["id"]), "lands": good}
    return _controller_of([*components.values()]) if components else None


def _controller_of(components: Sequence[Mapping[str, Any]]) -> Controller | None:
    made_up = "made up for a drawing"
    stand_in = {
        "id": "drawing", "name": "drawing", "source": made_up, "date": "2000-01-01", "gears": [1],
        "materials": {"any": {"expansion_per_k": 1e-5, "source": made_up}},
        "defaults": {"mounting_clearance_um": 10.0, "body": "any", "spool": "any"},
        "pump": {"displacement_mm3": 1.0, "volumetric_efficiency": 1.0, "source": made_up},
        "operating_points": [
            {"name": "any", "label": "any", "temperature_c": 20.0, "engine_rpm": 1000.0, "gear": 1, "p_g_kpa": 1.0,
             "p_k_kpa": 0.0, "source": made_up}
        ],
    }  # fmt: skip
    try:
        return checked_controller({**stand_in, "components": list(components)})
    except CatalogueError:
        return None
