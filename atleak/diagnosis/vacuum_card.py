"""Say what a vacuum stand should show of every circuit and land, and which of its orifices suits."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from atleak.catalogue.controller import Controller, Land
from atleak.common.sentences import Name
from atleak.diagnosis.uncertainty.assumptions import DEFAULTS, Assumptions
from atleak.diagnosis.vacuum_stand import stand_flow
from atleak.equations.gap import eccentricity_factor
from atleak.equations.vacuum import air_viscosity, circuit_pressure
from atleak.measurements.vacuum import VacuumStand, VacuumTable

ORIFICES = (0.25e-3, 0.5e-3, 1.0e-3)  # [m] that stands of the trade are fitted with
GROWN = 0.2  # of the leak of the widest new lands, that a pass mark lets by: choice of this project


@dataclass(frozen=True)
class PassMark:
    """What a stand shows of the lands of one circuit, or component, that leak as new ones, and as much as they may."""

    name: str  # of the circuit or component, for people
    circuit: str | None  # its id
    lands: tuple[Land, ...]
    orifice: float | None  # [m] the one of the stand that suits; None: the stand states its C_d A alone
    new: float  # [Pa] below ambient, of the widest new lands, spools anywhere
    mark: float  # [Pa] the reading from which on they leak at most `GROWN` more
    doubtful: float  # [Pa] the same with every spool touching its bore: a lower reading is no matter of position
    resolved: bool  # new and mark are further apart than the gauge can be off


def pass_marks(
    controller: Controller,
    stand: VacuumStand | None = None,
    *,
    by_land: bool = False,
    assumptions: Assumptions = DEFAULTS,
) -> tuple[PassMark, ...]:
    """Return what a stand should show of every circuit of a valve body, or of its components where it has no circuits.

    Parameters
    ----------
    stand
        that reads; that of the trade, 25 in-Hg, unless given.
    by_land
        of every land alone instead.
    assumptions
        C_d, the gauge's error, and how far from concentric spools may lie.

    Returns
    -------
    tuple of PassMark
        in the file's order, without those whose lands are all sealed by rings. Of the orifices with which the stand was
        calibrated, else of `ORIFICES`, each gets the one that tells new lands from grown ones best; none counts for a
        stand that states its C_d A.
    """
    stand = stand or VacuumStand()
    table = VacuumTable("", "", None, stand, ())
    fitted = tuple(dict.fromkeys(each.fitted for each in stand.calibrations))
    choices: Sequence[float | None] = fitted or ORIFICES
    if stand.flow_area is not None:
        choices = (None,)
    marks = []
    for name, circuit, around in _lands(controller) if by_land else _targets(controller):
        lands = tuple(land for land in around if not land.seal)
        if lands:
            made = [_mark(table, name, circuit, lands, orifice, assumptions) for orifice in choices]
            marks.append(max(made, key=lambda each: each.new - each.mark))
    return tuple(marks)


def _targets(controller: Controller) -> Iterator[tuple[str, str | None, Iterable[Land]]]:
    for circuit in controller.circuits:
        yield Name(circuit.name), circuit.id, controller.lands_around(circuit.id)
    for component in controller.components if not controller.circuits else ():
        yield component, None, controller.lands_of(component)


def _lands(controller: Controller) -> Iterator[tuple[str, str | None, Iterable[Land]]]:
    for land in controller.lands:
        yield f"{land.component}/{land.land}", None, (land,)


def _mark(
    table: VacuumTable,
    name: str,
    circuit: str | None,
    lands: tuple[Land, ...],
    orifice: float | None,
    assumptions: Assumptions,
) -> PassMark:
    stand, flow = table.stand, stand_flow(table, orifice, assumptions)
    assert flow is not None
    most = float(eccentricity_factor(assumptions.tested_position, 1.0))
    usual = 1.0 + (most - 1.0) / 3.0  # the mean of 1 + 1.5 e², any e up to that alike likely

    def shown(leak: float, factor: float) -> float:
        pressure = circuit_pressure(
            stand.ambient - stand.supply,
            stand.ambient,
            flow.area,
            [land.nominal_diameter for land in lands],
            [math.cbrt(leak) * land.widest_new for land in lands],
            [land.contact_length for land in lands],
            stand.temperature,
            air_viscosity(stand.temperature),
            factor,
        )
        return stand.ambient - float(pressure)

    new, mark, doubtful = shown(1.0, usual), shown(1.0 + GROWN, usual), shown(1.0 + GROWN, most)
    return PassMark(name, circuit, lands, orifice, new, mark, doubtful, new - mark > assumptions.vacuum_gauge)
