"""Set the tables of a file aside that are not well formed, so that what the others mean can be checked too."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pydantic import ValidationError

from atleak.catalogue.repairs import written_land
from atleak.common.errors import CatalogueError, KeySteps
from atleak.common.file_faults import steps_to

# What stands for a head, a pump, a material or a default that is wrong: none of it matters to the other tables.
_STAND_INS: dict[str, Any] = {
    "id": "unnamed",
    "name": "unnamed",
    "source": "none",
    "date": "2000-01-01",
    "pump": {"displacement_mm3": 1.0, "volumetric_efficiency": 1.0, "source": "none"},
}
_MATERIAL: dict[str, Any] = {"expansion_per_k": 1e-5, "source": "none"}
_NAMED_BY = {"components": "id", "lands": "land", "circuits": "id", "operating_points": "name"}  # where referred to
_DEFAULTS: dict[str, Any] = {"contact_length_mm": 1.0, "mounting_clearance_um": 10.0, "mounting_tolerance_um": 1.0}


@dataclass
class Remaining:
    """The tables of a controller's file that are well formed."""

    whole: Mapping[str, Any]  # all of the file
    data: dict[str, Any]
    kept: dict[KeySteps, list[int]] = field(default_factory=dict)  # by list: the places that its entries had before
    names: set[str] = field(default_factory=set)  # of the tables that were set aside
    lands: set[tuple[str, int]] = field(default_factory=set)  # likewise
    in_doubt: set[str] = field(default_factory=set)  # lists of which an entry's own name or number is wrong

    @classmethod
    def of(cls, data: Mapping[str, Any], error: ValidationError) -> Remaining:
        """Set aside what pydantic calls wrong: an unknown key alone, else the table or the land in which it stands."""
        remaining = cls(data, copy.deepcopy(dict(data)))
        aside: dict[KeySteps, set[int]] = {}
        faults = error.errors(include_url=False)
        for steps in (steps_to(fault) for fault in faults if fault["type"] == "extra_forbidden"):
            remaining._holder(steps).pop(steps[-1], None)
        for steps in (steps_to(fault) for fault in faults if fault["type"] != "extra_forbidden"):
            if len(steps) > 1 and isinstance(steps[1], int):
                of_land = len(steps) > 3 and steps[2] == "lands" and isinstance(steps[3], int)
                entry = steps[:4] if of_land else steps[:2]
                aside.setdefault(entry[:-1], set()).add(int(entry[-1]))
                listed = str(entry[-2])
                if steps == entry or steps == (*entry, _NAMED_BY.get(listed)):
                    remaining.in_doubt.add(listed)
                if steps == (*entry, "lands"):
                    remaining.in_doubt.add("lands")
            else:
                remaining._stand_in(steps)
        for path in sorted(aside, key=len, reverse=True):  # lands before the components that they stand in
            remaining._drop(path, aside[path])
        return remaining

    def _holder(self, steps: KeySteps) -> Any:
        holder: Any = self.data
        for step in steps[:-1]:
            holder = holder[step]
        return holder

    def _stand_in(self, steps: KeySteps) -> None:
        top = str(steps[0]) if steps else ""
        if top == "defaults":
            self._stand_in_default(str(steps[1]) if len(steps) > 1 else None)
        elif top in _STAND_INS:
            self.data[top] = copy.deepcopy(_STAND_INS[top])
        elif top == "materials" and len(steps) > 1 and isinstance(self.data[top], dict):
            self.data[top] = {**self.data[top], steps[1]: copy.deepcopy(_MATERIAL)}
        elif len(steps) > 1 and isinstance(self.data.get(top), dict):  # a pressure relation
            self.data[top].pop(steps[1], None)
            self.names.add(str(steps[1]))
        else:
            self.data.pop(top, None)

    def _stand_in_default(self, key: str | None) -> None:
        """Put something that fits in the place of one default; of all where there is no table of them."""
        material = next(iter(self.data["materials"]), None) if isinstance(self.data.get("materials"), dict) else None
        defaults = {**_DEFAULTS, "body": material, "spool": material}
        if key is None:
            self.data["defaults"] = defaults
        elif key in defaults:
            self.data["defaults"] = {**self.data["defaults"], key: defaults[key]}
        else:
            self.data["defaults"].pop(key, None)

    def _drop(self, path: KeySteps, numbers: set[int]) -> None:
        holder = self._holder(path)
        entries: list[Any] = holder[path[-1]]
        for number in numbers:
            self._remember(path, entries[number])
        self.kept[path] = [number for number in range(len(entries)) if number not in numbers]
        holder[path[-1]] = [entries[number] for number in self.kept[path]]

    def _remember(self, path: KeySteps, table: Any) -> None:
        """Keep the names under which others may refer to a table that is set aside."""
        if not isinstance(table, dict):
            return
        self.names |= {str(table[key]) for key in ("id", "name") if key in table}
        if path[0] != "components":
            return
        component = table if len(path) == 1 else self._holder((*path[:2], ""))
        lands = table.get("lands") if len(path) == 1 else [table]
        for land in lands if isinstance(lands, list) else []:
            if isinstance(land, dict) and isinstance(land.get("land"), int):
                self.lands.add((str(component.get("id")), land["land"]))

    def follows(self, fault: CatalogueError) -> bool:
        """Tell whether something is only wrong because a table to which it refers was set aside."""
        steps = fault.place.steps
        if fault.refers_to in self.in_doubt or str(fault.value) in self.names:
            return True
        if fault.refers_to == "lands":
            return "components" in self.in_doubt or self._refers_to_a_land_aside(fault)
        if steps[0] == "components" and steps[-1] == "lands":
            return bool(self.lands) or "lands" in self.in_doubt
        return steps[0] == "pressures" and str(steps[1]) in self.names

    def _refers_to_a_land_aside(self, fault: CatalogueError) -> bool:
        steps = fault.place.steps
        if steps[0] == "complaints":
            return fault.value in {written_land(key) for key in self.lands}
        table = self.whole[str(steps[0])][steps[1]]
        named = [table["land"]] if "land" in table else table.get("lands")
        mended = [table["component"]] if "component" in table else table["components"]
        return any(component in mended and (named is None or land in named) for component, land in self.lands)
