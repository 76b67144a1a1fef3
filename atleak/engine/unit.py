"""Take a unit up as a library: load it, change a clearance, and see what it leaks and holds over a range.

Calls and columns name their units: _c, _kpa, _um, _rpm, _dm3_min, _percent. Inside everything is SI.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import Any, Self

import pandas as pd

from atleak.catalogue.controller import Land
from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import InputError, translates_refusals, unknown
from atleak.common.printable import brief
from atleak.common.sentences import Sentence
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM, UM
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import find_profile
from atleak.engine.projection import project, stated_condition, with_even_clearance
from atleak.measurements.clearances import LandClearance, clearances

OneOrMany = float | Iterable[float] | None


def _name(land: Land) -> str:
    return "{}/{}".format(*land.key)


@brief
@dataclass(frozen=True)
class Unit(LeakageModel):
    """A valve body with its clearances and its fluid: a `LeakageModel` with calls in the units that people use.

    `load` gives one with every land new; ``diagnosis.model`` is the unit as it was measured. A unit never changes:
    `with_clearance` returns another.
    """

    clearances: tuple[LandClearance, ...]

    def land(self, name: str) -> Land:
        """Return a land of the valve body by its name.

        Parameters
        ----------
        name
            component and land, as ``"25/1"``.

        Raises
        ------
        InputError
            no such land.
        """
        lands = {_name(land): land for land in self.controller.lands}
        if name not in lands:
            raise unknown(Sentence("no such land"), name, lands)
        return lands[name]

    def with_clearance(self, land: str, *, um: float) -> Self:
        """Return the unit with another radial clearance of one land, cold (20 °C), the same all around.

        The spool keeps its diameter and the sleeve opens, so the mean diameter follows; the ovality and taper that were
        measured are gone with the clearance that had them.

        Parameters
        ----------
        land
            component and land, as ``"25/1"``.
        um
            radial clearance [µm], half of the difference of the diameters.

        Returns
        -------
        Unit
            all else as it was.

        Raises
        ------
        InputError
            no such land, or a clearance that is negative or no number.
        """
        key = self.land(land).key
        if not (isinstance(um, Real) and um >= 0.0 and math.isfinite(um)):
            raise InputError(Sentence("clearance not accepted"), value=um, expected=Sentence("0 or more"))
        even = (with_even_clearance(each, um / UM) if each.land.key == key else each for each in self.clearances)
        return replace(self, clearances=tuple(even))

    @translates_refusals
    def sweep(
        self,
        at: str | None = None,
        *,
        temperature_c: OneOrMany = None,
        engine_rpm: OneOrMany = None,
        main_pressure_kpa: OneOrMany = None,
        gear: OneOrMany = None,
        land: str | None = None,
        clearance_um: OneOrMany = None,
    ) -> pd.DataFrame:
        """Compute leakage, pump flow and the pressures held over a range of one quantity, or of several.

        Parameters
        ----------
        at
            name of one of the valve body's operating points, which gives what is not stated; its first unless given.
        temperature_c
            of the fluid and the valve body [°C]; one value or several, as all below.
        engine_rpm
            [1/min].
        main_pressure_kpa
            required main pressure p_g [kPa]; unless given what the line is set to at the operating point.
        gear
            the gear engaged.
        land
            component and land whose clearance is varied, and of which a column says what it leaks.
        clearance_um
            cold radial clearance of that land [µm], as `with_clearance` sets it.

        Returns
        -------
        pandas.DataFrame
            a row for each combination of the values, which are the index; names of columns say the unit. Leakage and
            share are those at the required pressure; ``p_g_held_kpa`` and the circuits' columns, by their ids, say what
            holds against the leakage; ``notes`` the codes of what a reader must know of a row, such as that the share
            is a demand that the pump cannot meet.

        Raises
        ------
        DomainError
            a temperature outside the fluid's data.
        InputError
            no such operating point, gear or land, or a value that nothing can have.
        """
        points = {point.name: point for point in self.controller.operating_points}
        if at is not None and at not in points:
            raise unknown(Sentence("no such operating point"), at, points)
        base = self.controller.operating_points[0] if at is None else points[at]
        if clearance_um is not None and land is None:
            raise unknown(Sentence("no such land"), land, map(_name, self.controller.lands))
        given = {
            "temperature_c": temperature_c,
            "engine_rpm": engine_rpm,
            "main_pressure_kpa": main_pressure_kpa,
            "gear": gear,
            "clearance_um": clearance_um,
        }
        stated = {name: values for name, values in given.items() if values is not None}
        axes: dict[str, list[Any]] = {
            name: list(values)
            for name, values in stated.items()
            if isinstance(values, Iterable) and not isinstance(values, str) and getattr(values, "ndim", True)
        }
        fixed = {name: value for name, value in stated.items() if name not in axes}
        if not axes:
            axes = {name: [value] for name, value in fixed.items()} or {"temperature_c": [base.temperature]}
        for name, value in [*fixed.items(), *((name, value) for name, values in axes.items() for value in values)]:
            if not isinstance(value, Real):
                problem = Sentence("{where}: {problem}", where=name, problem=Sentence("not a number"))
                raise InputError(problem, value=value)
        every = list(itertools.product(*axes.values()))
        rows = [self._row(base, land, {**fixed, **dict(zip(axes, each, strict=True))}) for each in every]
        index = pd.MultiIndex.from_tuples(every, names=list(axes))
        return pd.DataFrame(rows, index=index if len(axes) > 1 else index.get_level_values(0))

    def _row(self, base: OperatingPoint, land: str | None, values: dict[str, Any]) -> dict[str, Any]:
        unit, speed, pressure = self, values.get("engine_rpm"), values.get("main_pressure_kpa")
        if land is not None and "clearance_um" in values:
            unit = self.with_clearance(land, um=values["clearance_um"])
        point = stated_condition(
            self.controller,
            temperature=values.get("temperature_c"),
            engine_speed=None if speed is None else speed / RPM,
            gear=values.get("gear"),
            main_pressure=None if pressure is None else pressure / KPA,
            base=base,
        )
        found = project(unit, point)
        of_land = {} if land is None else {"land_leakage_dm3_min": found.leakage_of(self.land(land).key) * DM3_MIN}
        return {
            "leakage_dm3_min": found.leakage * DM3_MIN,
            **of_land,
            "pump_capacity_dm3_min": found.pump_capacity * DM3_MIN,
            "share_percent": found.share * PERCENT,
            "reserve": found.reserve,
            "p_g_held_kpa": found.main_pressure_held * KPA,
            **{f"{each.circuit.id}_kpa": each.pressure * KPA for each in found.circuits},
            "notes": ", ".join(dict.fromkeys(message.code for message in found.messages)),
        }


def load(controller: str | Path, *, fluid: str | Path | None = None, profile: str = "workshop", **options: Any) -> Unit:
    """Load a valve body with its fluid, every land new and nothing measured.

    Parameters
    ----------
    controller
        id of one that ships or of the workshop's own, or the path of a file.
    fluid
        likewise; the one that the controller's file names unless given.
    profile
        how to compute: ``workshop``, or ``paper`` as the article printed.
    **options
        those of the profile that are set apart from it, by the attributes of `Profile`.

    Returns
    -------
    Unit
        ready to be changed and swept.

    Raises
    ------
    CatalogueError
        no such entry, or a file that cannot be used.
    InputError
        no such profile or option.

    Examples
    --------
    >>> unit = load("four_speed_2023")
    >>> worn = unit.with_clearance("25/1", um=40)
    >>> worn.sweep(temperature_c=range(20, 121, 50))["leakage_dm3_min"].round(2).to_list()
    [0.14, 1.41, 5.74]
    """
    body = load_controller(controller)
    chosen = load_fluid(body.usual_fluid if fluid is None else fluid)
    chosen = chosen if body.fluid is None else body.fluid.taken(chosen)
    return Unit(body, clearances(None, body), chosen, find_profile(profile).with_options(**options))
