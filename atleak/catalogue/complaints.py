"""Map what a customer complains of to the operating points and lands of a controller that can explain it."""

from __future__ import annotations

from dataclasses import dataclass

from atleak.catalogue.entries import ID_HELP, Identifier, NonEmptyText, Source, Strict
from atleak.catalogue.keys import key

LandKey = tuple[str, int]


class ComplaintTable(Strict):
    """A complaint as a controller's file states it; lands are written ``"8/1"``, component and land."""

    id: Identifier = key("Id", ID_HELP, width=20)
    label: NonEmptyText = key("Label", "What people see", width=30)
    conditions: list[Identifier] = key("Operating points", "Their names, with commas", width=28, min_length=1)
    lands: list[NonEmptyText] | None = key(
        "Lands", "That can explain it: boost_valve/2, 8/1", width=24, default=None, min_length=1
    )
    source: Source | None = key("Source", "Manual and page, or who measured it", width=40, default=None)


@dataclass(frozen=True)
class Complaint:
    """What a customer says, and where the leakage behind it shows."""

    id: str
    label: str
    conditions: tuple[str, ...]  # names of operating points
    lands: tuple[LandKey, ...]  # that can explain it; none where every land that leaks in those conditions can
    source: str

    @property
    def record(self) -> dict[str, str | list[str]]:
        """Return the complaint as the catalogue lists it."""
        return {
            "id": self.id,
            "label": self.label,
            "conditions": list(self.conditions),
            "lands": [written_land(key) for key in self.lands],
            "source": self.source,
        }


def written_land(key: LandKey) -> str:
    """Write a land as complaints name it: ``8/1``."""
    component, land = key
    return f"{component}/{land}"
