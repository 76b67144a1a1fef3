"""Which diameters of a valve body are to be measured, and in which order."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any

from pydantic import Field

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.instruments import Part
from atleak.catalogue.repairs import LandKey

DIRECTIONS = (0.0, 90.0)  # [°] of the printed sheet, and of a plan unless another number is chosen
REPEATS = 2
MOST_DIRECTIONS, MOST_REPEATS = 4, 5  # that a plan can have: choice of this project
QUICK_LANDS = 10  # of a quick pass at the most: choice of this project
PLAN_PARTS: tuple[Part, ...] = ("spool", "sleeve")
CellKey = tuple[str, Part, str, float | None, int]


class Order(StrEnum):
    """What is measured first: every spool, every part of a component or of a land, or the lands that tell most."""

    PARTS = "parts"
    COMPONENTS = "components"
    LANDS = "lands"
    QUICK = "quick"  # the lands of the plan as it lists them, each in its middle plane


@dataclass(frozen=True)
class PlanCell:
    """One diameter to be measured: of a part in a plane, in a direction [°], and how often before."""

    component: str
    part: Part
    plane: str
    direction: float | None  # None where a sheet does not say
    repeat: int  # from 1

    @property
    def key(self) -> CellKey:
        """Return it as plain values, by which a page names it."""
        return self.component, self.part, self.plane, self.direction, self.repeat


@dataclass(frozen=True)
class Plan:
    """What is to be measured of a valve body; pydantic checks one that is read from a file."""

    order: Order = Order.PARTS
    directions: Annotated[int, Field(ge=1, le=MOST_DIRECTIONS)] = len(DIRECTIONS)  # evenly round the bore
    repeats: Annotated[int, Field(ge=1, le=MOST_REPEATS)] = REPEATS
    planes: Annotated[int, Field(ge=1)] | None = None  # of each land, the first ones; None: all
    lands: tuple[LandKey, ...] = ()  # none: every land

    @classmethod
    def quick(cls, lands: Iterable[LandKey]) -> Plan:
        """Return the plan of lands one after the other, each read once: in one plane, in one direction."""
        return cls(Order.QUICK, directions=1, repeats=1, lands=tuple(lands))

    def angles(self) -> tuple[float, ...]:
        """Return the directions [°].

        >>> Plan().angles(), Plan(directions=3).angles()
        ((0.0, 90.0), (0.0, 60.0, 120.0))
        """
        return tuple(180.0 * number / self.directions for number in range(self.directions))

    def takes(self, land: Land) -> bool:
        """Return whether a land is to be measured."""
        return not self.lands or land.key in self.lands

    def of_land(self, land: Land) -> tuple[PlanCell, ...]:
        """Return the cells that the plan asks of a land."""
        middle = (len(land.planes) - 1) // 2
        planes = land.planes[middle : middle + 1] if self.order is Order.QUICK else land.planes[: self.planes]
        return tuple(
            PlanCell(land.component, part, plane, angle, repeat)
            for part in PLAN_PARTS
            for plane in planes
            for angle in self.angles()
            for repeat in range(1, self.repeats + 1)
        )

    def cells(self, controller: Controller, held: Iterable[PlanCell] = ()) -> tuple[PlanCell, ...]:
        """Return every cell in the order of measuring.

        ``held`` are cells that hold something: those of the plan's lands stay, also where it does not ask for them.
        """
        wanted = [land for land in controller.lands if self.takes(land)]
        cells = dict.fromkeys(cell for land in wanted for cell in self.of_land(land))
        keys = {land.key for land in wanted}
        for cell in held:
            land = controller.land_of_plane(cell.component, cell.plane)
            if land is not None and land.key in keys:
                cells.setdefault(cell)
        return self.in_order(controller, cells)

    def in_order(self, controller: Controller, cells: Iterable[PlanCell]) -> tuple[PlanCell, ...]:
        """Return cells of the controller in the order of measuring."""
        components = {name: number for number, name in enumerate(controller.components)}
        planes = {
            (land.component, plane): (land.land, number)
            for land in controller.lands
            for number, plane in enumerate(land.planes)
        }

        listed = {key: number for number, key in enumerate(self.lands)}

        def place(cell: PlanCell) -> tuple[Any, ...]:
            component, part = components[cell.component], PLAN_PARTS.index(cell.part)
            land, plane = planes[cell.component, cell.plane]
            first = {
                Order.PARTS: (part, component, land),
                Order.COMPONENTS: (component, part, land),
                Order.LANDS: (component, land, part),
                Order.QUICK: (listed.get((cell.component, land), len(listed)), component, land, part),
            }[self.order]
            return *first, plane, -1.0 if cell.direction is None else cell.direction, cell.repeat

        return tuple(sorted(cells, key=place))
