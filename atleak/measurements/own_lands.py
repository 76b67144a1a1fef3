"""What one unit's lands have of their own, beside their diameters: lengths as measured, and repairs fitted earlier."""

from __future__ import annotations

from dataclasses import dataclass, replace

from atleak.catalogue.controller import Controller, Land
from atleak.catalogue.repairs import LandKey
from atleak.common.errors import Place, ReadingsError, unknown
from atleak.common.sentences import Sentence

LENGTHS_MEASURED, REPAIR_FITTED = "contact_length_measured", "repair_fitted"  # codes of the messages that say so


@dataclass(frozen=True)
class OwnLength:
    """The contact length of one land as measured, or where it begins on its spool; None where not measured."""

    component: str
    land: int
    contact_length: float | None  # [m]
    position: float | None  # [m] of its near edge, from the end of the spool that the drawing shows left
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share

    @property
    def key(self) -> LandKey:
        return self.component, self.land


@dataclass(frozen=True)
class FittedRepair:
    """A repair of the controller's file that one component was given earlier, by its id."""

    component: str
    repair: str
    place: Place = Place()  # noqa: RUF009  frozen, so safe to share


@dataclass(frozen=True)
class OwnLands:
    """All of that of one unit, as its measuring sheet says it."""

    lengths: tuple[OwnLength, ...] = ()
    fitted: tuple[FittedRepair, ...] = ()

    def with_fitted(self, controller: Controller) -> Controller:
        """Return the controller with the nominal diameters and mounting clearances of the repairs that are fitted.

        A `ReadingsError` names one that the controller's file does not have for that component.
        """
        if not self.fitted:
            return controller
        lands = {land.key: land for land in controller.lands}
        for fitted in self.fitted:
            options = {repair.id: repair for repair in controller.repairs_of(fitted.component)}
            repair = options.get(fitted.repair)
            if repair is None:
                problem = Sentence(
                    "{controller} has no such repair of component {component}",
                    controller=controller.id,
                    component=fitted.component,
                )
                raise unknown(problem, fitted.repair, options, kind=ReadingsError, place=fitted.place)
            for land in controller.lands_of(fitted.component):
                if repair.changes(land.key):
                    lands[land.key] = land.with_repair(repair)
        return replace(controller, lands=tuple(lands.values()))

    def applied(self, controller: Controller) -> Controller:
        """Return the controller as this unit is: as `with_fitted` does, and with the lengths that were measured."""
        lengths = {length.key: length for length in self.lengths}
        fitted = self.with_fitted(controller)
        lands = tuple(_measured(land, lengths[land.key]) if land.key in lengths else land for land in fitted.lands)
        return replace(fitted, lands=lands) if lengths else fitted


def _measured(land: Land, length: OwnLength) -> Land:
    """Return a land with the contact length and position that were measured of it."""
    if length.position is not None:
        land = replace(land, position=length.position)
    if length.contact_length is None:
        return land
    representative = tuple(key for key in land.representative if key != "contact_length_mm")
    return replace(
        land, contact_length=length.contact_length, contact_length_measured=True, representative=representative
    )
