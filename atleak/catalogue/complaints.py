"""Map what a customer complains of to the operating points and lands of a controller that can explain it."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field

from atleak.catalogue.entries import Identifier, NonEmptyText, Strict, catalogue_error
from atleak.errors import CatalogueError, InputError, Place, unknown

LandKey = tuple[str, int]


class ComplaintTable(Strict):
    """A complaint as a controller's file states it; lands are written ``"8/1"``, component and land."""

    id: Identifier
    label: NonEmptyText
    conditions: list[Identifier] = Field(min_length=1)
    lands: list[NonEmptyText] | None = Field(default=None, min_length=1)
    source: NonEmptyText | None = None


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
            "lands": [_written(key) for key in self.lands],
            "source": self.source,
        }


def complaints_of(
    tables: Iterable[ComplaintTable], points: Sequence[str], lands: Collection[LandKey], source: str, path: Path
) -> tuple[Complaint, ...]:
    """Check the complaints of a controller's file against its operating points and lands.

    Parameters
    ----------
    tables
        as the file states them.
    points
        names of the controller's operating points.
    lands
        component and number of the controller's lands.
    source
        of the file, for complaints that state none of their own.
    path
        of the file, for messages.

    Raises
    ------
    CatalogueError
        an id given twice, a condition or land that the controller does not have, or one that is given twice.
    """
    names = {_written(key): key for key in lands}
    made: dict[str, Complaint] = {}
    for number, table in enumerate(tables, start=1):
        where = f"complaints[{number}] ({table.id})"
        if table.id in made:
            raise catalogue_error(path, where, "id", "complaint given twice", value=table.id)
        _each_known_once(table.conditions, points, path, where, "conditions", "operating point")
        _each_known_once(table.lands or (), names, path, where, "lands", "land")
        made[table.id] = Complaint(
            id=table.id,
            label=table.label,
            conditions=tuple(table.conditions),
            lands=tuple(names[name] for name in table.lands or ()),
            source=table.source or source,
        )
    return tuple(made.values())


def find_complaint(complaints: Sequence[Complaint], wanted: str | None, controller: str) -> Complaint | None:
    """Return the complaint of that id; None where none is wanted.

    Raises
    ------
    InputError
        if the controller maps no such complaint; it lists those that it maps, or says that it maps none.
    """
    if wanted is None:
        return None
    known = {complaint.id: complaint for complaint in complaints}
    if wanted in known:
        return known[wanted]
    if not known:
        expected = "no complaint, or a controller's file with a table [[complaints]]"
        raise InputError(f"{controller} maps no complaint to its operating points", value=wanted, expected=expected)
    raise unknown(f"{controller} maps no such complaint", wanted, known)


def _written(key: LandKey) -> str:
    component, land = key
    return f"{component}/{land}"


def _each_known_once(given: Sequence[str], known: Collection[str], path: Path, where: str, key: str, what: str) -> None:
    for name in given:
        if name not in known:
            place = Place(file=path.name, table=where, key=key)
            raise unknown(f"no such {what} in this controller", name, known, kind=CatalogueError, place=place)
        if given.count(name) > 1:
            raise catalogue_error(path, where, key, f"{what} given twice", value=name)
