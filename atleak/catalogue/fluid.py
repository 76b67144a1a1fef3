"""Describe a fluid: from data-sheet points, viscosity and density over temperature, and where to trust them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from pydantic import Field, field_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.doubts import doubts_of
from atleak.catalogue.entries import (
    NO_ENTRY,
    Entry,
    Headed,
    Origin,
    Shelf,
    Strict,
    id_from_name,
    read_tables,
    shipped_files,
)
from atleak.catalogue.keys import key, made
from atleak.common.errors import CatalogueError, DomainError, InputError, Message, Place, unknown
from atleak.common.file_faults import NotAccepted, place_of, validated
from atleak.common.printable import brief
from atleak.common.sentences import Name, Sentence
from atleak.common.units import PERCENT, Quantity
from atleak.equations import fluid as fluid_equations
from atleak.equations.fluid import ASTM_D341_RELIABLE_FROM, STUDY_HIGHEST, STUDY_LOWEST

ViscosityModel = Literal["d341", "tabulated", "regression"]
FluidState = Literal["fresh", "used"]
# Viscosity of a used fluid over that of the fresh one, where the fluid has no data of its own used state: choice of
# this project after the source study's fluid, which had lost 23 % at 80 °C after 106 315 km. Representative.
_USED_VISCOSITY = (0.75, 0.80)
USED_THINNER = tuple(round(PERCENT * (1.0 - factor)) for factor in reversed(_USED_VISCOSITY))  # [%] from, to
HIGHEST_TEMPERATURE = 150.0  # °C: no source in the catalogue measured a fluid above it


@brief
@dataclass(frozen=True)
class Fluid(Headed):
    """One automatic transmission fluid.

    Attributes
    ----------
    representative
        which of its values are representative.
    points
        the data sheet's (temperature [°C], kinematic viscosity [m²/s]).
    table
        (temperature [°C], kinematic viscosity [m²/s], density [kg/m³]) where a source tabulates both.
    density_at
        (temperature [°C], density [kg/m³]) of the data sheet.
    density_slope
        change of density with temperature [kg/(m³·K)].
    pour_point
        below it nothing is computed [°C]; None where none is stated.
    study_regression
        whether the source study's eqs. (29) and (30) describe this fluid.
    state
        whether the data are those of the fresh or the used fluid.
    used
        id of the entry with this fluid's used data.
    viscosity_range
        of what is given: the viscosity may lie anywhere from the first to the second of these times it.
    origin
        the file.
    doubts
        values that are possible and unusual.
    fresh
        the fluid of which this is the used state, made by `in_state`.
    """

    representative: tuple[str, ...]
    points: tuple[tuple[float, float], ...]
    table: tuple[tuple[float, float, float], ...]
    density_at: tuple[float, float]
    density_slope: float
    pour_point: float | None
    study_regression: bool
    state: FluidState
    used: str | None
    viscosity_range: tuple[float, float]
    origin: Origin
    doubts: tuple[Message, ...] = field(default=(), repr=False, compare=False)
    fresh: Fluid | None = field(default=None, repr=False, compare=False)

    def in_state(self, state: FluidState) -> Fluid:
        """Return this fluid fresh or used.

        Parameters
        ----------
        state
            the state wanted.

        Returns
        -------
        Fluid
            used, with its own used data where its file names them; else with the fresh one's density and a viscosity
            thinner by `USED_THINNER`, the middle as the value and the width in `viscosity_range`.

        Raises
        ------
        InputError
            if fresh is asked of data that describe a used fluid.
        """
        if state == self.state:
            return self
        if state == "fresh":
            if self.fresh is not None:
                return self.fresh
            problem = Sentence("the data of {fluid} describe a used fluid", fluid=Name(self.name))
            raise InputError(problem, value=state, expected=Sentence("used, or the file of the fresh fluid"))
        if self.used is not None:
            return replace(load_fluid(self.used), fresh=self, viscosity_range=self.viscosity_range)
        (low, high), (thinnest, thickest) = _USED_VISCOSITY, self.viscosity_range
        middle = 0.5 * (low + high)
        return replace(
            self,
            state="used",
            points=tuple((at, nu * middle) for at, nu in self.points),
            table=tuple((at, nu * middle, rho) for at, nu, rho in self.table),
            study_regression=False,  # it was fitted to a fresh fluid
            representative=(*self.representative, Sentence("viscosity and density of the used fluid")),
            viscosity_range=(thinnest * low / middle, thickest * high / middle),
            fresh=self,
        )

    @property
    def estimated(self) -> bool:
        """Return whether the data are those of the fresh fluid, made thinner for want of data of the used one."""
        return self.fresh is not None and self.fresh.used is None

    def viscosity_factor(self, deviate: Any) -> Any:
        """Return by which factor of `viscosity_range` the viscosity is another one than given.

        Parameters
        ----------
        deviate
            of a rectangular distribution of mean 0 and standard deviation 1, a number or an array.
        """
        low, high = self.viscosity_range
        return 0.5 * (low + high) + (high - low) / math.sqrt(12.0) * deviate

    def kinematic_viscosity(self, temperature_c: Any, model: ViscosityModel = "d341") -> Any:
        """Compute the kinematic viscosity.

        Parameters
        ----------
        temperature_c
            [°C], a number or an array.
        model
            ``d341``: ASTM D341 through the lowest and highest data-sheet point. ``tabulated``: straight lines of log ν
            between the table's points (the data sheet's where there is no table). ``regression``: the source study's
            eq. (29), whatever the fluid.

        Returns
        -------
        float or array
            ν [m²/s] in the shape of ``temperature_c``; NaN outside `span`. `messages` says where the model is weak.
        """
        return _plain(self._viscosity(self._inside(temperature_c, model), model))

    def density(self, temperature_c: Any, model: ViscosityModel = "d341") -> Any:
        """Compute the density.

        Parameters
        ----------
        temperature_c
            [°C], a number or an array.
        model
            ``tabulated`` takes the table's density, linear between points, ``regression`` eq. (30); any other model
            takes a line through the data sheet's point.

        Returns
        -------
        float or array
            ρ [kg/m³] in the shape of ``temperature_c``; NaN outside `span`.
        """
        return _plain(self._density(self._inside(temperature_c, model), model))

    def dynamic_viscosity(self, temperature_c: Any, model: ViscosityModel = "d341") -> Any:
        """Compute the dynamic viscosity, μ = ν·ρ.

        Parameters
        ----------
        temperature_c
            [°C], a number or an array.
        model
            as `kinematic_viscosity` and `density` take it.

        Returns
        -------
        float or array
            μ [Pa·s] in the shape of ``temperature_c``; NaN outside `span`.
        """
        inside = self._inside(temperature_c, model)
        return fluid_equations.dynamic_viscosity(self._viscosity(inside, model), self._density(inside, model))

    def span(self, model: ViscosityModel = "d341") -> tuple[float, float]:
        """Return the lowest and the highest temperature [°C] at which a model answers.

        Parameters
        ----------
        model
            as `kinematic_viscosity` takes it.
        """
        if model == "regression":
            return STUDY_LOWEST, STUDY_HIGHEST
        if model == "tabulated":
            temperatures = [row[0] for row in self.table or self.points]
            return min(temperatures), max(temperatures)
        lowest = self.pour_point if self.pour_point is not None else ASTM_D341_RELIABLE_FROM
        return lowest, HIGHEST_TEMPERATURE

    def require(self, temperature_c: float, model: ViscosityModel = "d341") -> None:
        """Raise where a model has no answer.

        Parameters
        ----------
        temperature_c
            [°C].
        model
            as `kinematic_viscosity` takes it.

        Raises
        ------
        DomainError
            if the temperature is below the pour point, or outside the fluid's data.
        """
        low, high = self.span(model)
        if low <= temperature_c <= high:
            return
        at, lowest, highest = (Quantity(each, "temperature") for each in (temperature_c, low, high))
        if model == "d341" and temperature_c < low:
            limit = Sentence("where D341 holds (no pour point is stated)")
            raise DomainError(
                Sentence(
                    "{fluid}: {at:g} {at.unit} is below {limit}, {lowest:g} {lowest.unit}",
                    fluid=Name(self.name),
                    at=at,
                    limit=limit if self.pour_point is None else Sentence("its pour point"),
                    lowest=lowest,
                )
            )
        raise DomainError(
            Sentence(
                "{fluid}: {at:g} {at.unit} is outside the fluid's data ({model}), "
                "{lowest:g} to {highest:g} {highest.unit}",
                fluid=Name(self.name),
                at=at,
                model=model,
                lowest=lowest,
                highest=highest,
            )
        )

    def messages(self, lowest: float, highest: float, model: ViscosityModel = "d341") -> list[Message]:
        """Return what a reader must know of results between two temperatures.

        Parameters
        ----------
        lowest, highest
            the two temperatures [°C].
        model
            as `kinematic_viscosity` takes it.
        """
        messages = []
        if model == "d341" and not fluid_equations.astm_d341_reliable(lowest):
            text = Sentence(
                "Below {lowest:g} {lowest.unit} ASTM D341 under-predicts the viscosity of real ATF 1.2 to 3.4 times.",
                lowest=Quantity(ASTM_D341_RELIABLE_FROM, "temperature"),
            )
            messages.append(Message("warning", "viscosity_cold", text))
        if model == "regression" and not self.study_regression:
            fluid: Sentence | Name = Name(self.name)
            if self.estimated:
                fluid = Sentence("{fluid}, used", fluid=Name(self.name))
            text = Sentence("The study's viscosity regression describes fresh HIPOL ATF IID, not {fluid}.", fluid=fluid)
            messages.append(Message("warning", "viscosity_of_another_fluid", text))
        if model == "tabulated" and not self.table:
            text = Sentence(
                "{fluid} has no table of viscosities: straight lines of log ν join its data-sheet points, which "
                "between {low:g} and {high:g} {high.unit} can lie some 10 % above ASTM D341.",
                fluid=Name(self.name),
                low=Quantity(40.0, "temperature"),
                high=Quantity(100.0, "temperature"),
            )
            messages.append(Message("warning", "viscosity_between_few_points", text))
        if self.estimated:
            low, high = USED_THINNER
            text = Sentence(
                "{fluid}: there are no data of the used fluid. Its viscosity is taken {low} to {high} % below the "
                "fresh one's (assumed: choice of this project), its density as that of the fresh one.",
                fluid=Name(self.name),
                low=low,
                high=high,
            )
            messages.append(Message("warning", "fluid_used_estimated", text))
        if self.representative:
            text = Sentence(
                "{fluid}: assumed, not from the data sheet: {names}.",
                fluid=Name(self.name),
                names=tuple(text if isinstance(text, Sentence) else Name(text) for text in self.representative),
            )
            messages.append(Message("info", "fluid_representative", text))
        if self.note:
            text = Sentence("{fluid}: {note}", fluid=Name(self.name), note=Name(self.note))
            messages.append(Message("info", "fluid_note", text))
        span = self.points[0][0], self.points[-1][0]
        if model == "d341" and highest > span[1] + 20.0:
            text = Sentence(
                "{highest:g} {highest.unit} is well above the data sheet's last point ({last:g} {last.unit}).",
                highest=Quantity(highest, "temperature"),
                last=Quantity(span[1], "temperature"),
            )
            messages.append(Message("warning", "viscosity_extrapolated", text))
        return messages

    def _inside(self, temperature: Any, model: ViscosityModel) -> np.ndarray:
        """Return the temperatures, NaN outside the model's span."""
        temperature = np.asarray(temperature, dtype=float)
        low, high = self.span(model)
        if temperature.size and not (temperature.min() >= low and temperature.max() <= high):
            return np.where((temperature >= low) & (temperature <= high), temperature, np.nan)
        return temperature

    def _density(self, temperature: np.ndarray, model: ViscosityModel) -> Any:
        if model == "tabulated" and self.table:
            return _between_points(temperature, self._knots[0], self._knots[2])
        if model == "regression":
            return fluid_equations.study_density(temperature)
        at, density = self.density_at
        line = np.subtract(temperature, at, out=np.empty(temperature.shape))
        line *= self.density_slope
        line += density
        return line

    def _viscosity(self, temperature: np.ndarray, model: ViscosityModel) -> Any:
        if model == "d341":
            return fluid_equations.astm_d341(temperature, *self.d341)
        if model == "regression":
            return fluid_equations.study_viscosity(temperature)
        logarithm = np.asarray(_between_points(temperature, self._knots[0], self._knots[1]))
        return np.exp(logarithm, out=logarithm) if logarithm.ndim else np.exp(logarithm)

    @cached_property
    def _knots(self) -> np.ndarray:
        """Return temperature, ln ν and, where a table gives it, density of the tabulated points, as rows."""
        temperatures, viscosities, *densities = np.array(self.table or self.points).T
        return np.stack([temperatures, np.log(viscosities), *densities])

    @cached_property
    def d341(self) -> tuple[float, float]:
        """Return the coefficients A and B of ASTM D341."""
        (t_1, nu_1), (t_2, nu_2) = self.points[0], self.points[-1]
        return fluid_equations.astm_d341_coefficients(t_1, nu_1, t_2, nu_2)


def tables_of_two_points(
    name: str, source: str, day: str, at_40: float, at_100: float, density: float | None = None
) -> dict[str, Any]:
    """Return the tables of a fluid's file from what any data sheet states; the rest is representative.

    Parameters
    ----------
    name, source, day
        what people see, where the numbers come from, and when they were read, as ``2026-01-31``.
    at_40, at_100
        kinematic viscosities at 40 and 100 °C [mm²/s].
    density
        at 15 °C [g/cm³]; unless given that of transmission fluids in general.
    """
    assumed = ["density_slope_g_cm3_k"] if density else ["density_g_cm3", "density_slope_g_cm3_k"]
    return {
        "id": id_from_name(name),
        "name": name,
        "source": source,
        "date": day,
        "representative": assumed,
        "density": {"density_g_cm3": density or 0.85, "density_slope_g_cm3_k": -0.0007},
        "viscosity": [
            {"temperature_c": 40.0, "kinematic_viscosity_mm2_s": at_40},
            {"temperature_c": 100.0, "kinematic_viscosity_mm2_s": at_100},
        ],
    }


FluidChoice = Literal["required", "assumed", "other"]


@dataclass(frozen=True)
class RequiredFluid:
    """The fluid that a unit's maker requires, and the entry that is taken for it unless another is chosen."""

    required: str  # as the manual calls it
    entry: str  # id of that fluid's entry, or of the nearest one
    viscosity_100: tuple[float, float] | None  # [m²/s] at 100 °C, where the entry is but the nearest: of what is sold
    source: str  # who requires it

    def choice(self, fluid: Fluid) -> FluidChoice:
        """Return whether a fluid is the one required, the one that is assumed to be near it, or another one.

        One whose name holds that of the required fluid is that.
        """
        if self.required.casefold() in (fluid.fresh or fluid).name.casefold():
            return "required"
        if fluid.state == "used" and fluid.fresh is None:  # data of a used fluid, chosen as such
            used = shipped_files("fluids").get(self.entry) and load_fluid(self.entry).used
            other = fluid.id not in (self.entry, used)
        else:
            other = (fluid.fresh or fluid).id != self.entry
        return "other" if other else "required" if self.viscosity_100 is None else "assumed"

    def taken(self, fluid: Fluid) -> Fluid:
        """Return a fluid with the range of what is sold as the one required, where it is assumed to be near that.

        A fluid whose range is known already stays as it is.
        """
        if self.viscosity_100 is None or self.choice(fluid) != "assumed" or fluid.viscosity_range != (1.0, 1.0):
            return fluid
        of_used = fluid.state == "used" and fluid.fresh is None  # data of its own: the range is that of fresh fluid
        nu = (load_fluid(self.entry) if of_used else fluid).kinematic_viscosity(100.0)
        low, high = self.viscosity_100
        return replace(fluid, viscosity_range=(low / nu, high / nu))

    def messages(self, fluid: Fluid) -> list[Message]:
        """Return what a reader must know of a fluid that is not surely the one required."""
        choice = self.choice(fluid)
        if choice == "other":
            text = Sentence(
                "The maker requires {required}; this unit is computed with {fluid}, which was chosen.",
                required=Name(self.required),
                fluid=Name(fluid.name),
            )
            return [Message("warning", "fluid_not_required", text)]
        if self.viscosity_100 is None or choice == "required":
            return []
        low, high = (each * 1e6 for each in self.viscosity_100)
        text = Sentence(
            "{fluid} is assumed: the maker requires {required}, of which no entry is known. At 100 °C what is sold as "
            "that has {low:g} to {high:g} mm²/s; every flow is uncertain by as much.",
            fluid=Name(fluid.name),
            required=Name(self.required),
            low=round(low, 6),
            high=round(high, 6),
        )
        return [Message("info", "fluid_assumed", text)]


def fresh_assumed(fluid: Fluid) -> Message:
    """Return the message that nobody said in which state a fluid is."""
    low, high = USED_THINNER
    text = Sentence(
        "{fluid} is taken as fresh: nobody said whether it is fresh or used. Used fluid is some {low} to {high} "
        "% thinner, and every gap leaks the more.",
        fluid=Name(fluid.name),
        low=low,
        high=high,
    )
    return Message("info", "fluid_state_assumed", text)


def _fluid(data: Mapping[str, Any], origin: Origin) -> Fluid:
    entry = validated(FluidFile, data, origin.file, kind=CatalogueError)
    points = _falling("viscosity", entry.viscosity, data, origin)
    rows = _falling("table", entry.table, data, origin)
    return made(
        Fluid,
        entry,
        points=tuple((row.temperature_c, row.kinematic_viscosity_mm2_s * 1e-6) for row in points),
        table=tuple((row.temperature_c, row.kinematic_viscosity_mm2_s * 1e-6, row.density_g_cm3 * 1e3) for row in rows),
        density_at=(entry.density.at_c, entry.density.density_g_cm3 * 1e3),
        density_slope=entry.density.density_slope_g_cm3_k * 1e3,
        used=_used_entry(entry, origin),
        viscosity_range=(1.0, 1.0),
        origin=origin,
        doubts=doubts_of("fluids", FluidFile, data, origin.file),
    )


def _used_entry(entry: FluidFile, origin: Origin) -> str | None:
    """Check that the entry with a fluid's used data describes a used fluid, and ships: a job file holds one fluid."""
    if entry.used is None:
        return None
    place = Place(file=origin.file, key="used", steps=("used",))
    if entry.state == "used":
        problem = Sentence("a used fluid has no used state of its own")
        raise CatalogueError(problem, place=place, value=entry.used)
    shipped = shipped_files("fluids")
    if entry.used not in shipped:
        raise unknown(NO_ENTRY["fluids"], entry.used, shipped, kind=CatalogueError, place=place)
    if read_tables("fluids", entry.used)[0].get("state") != "used":
        problem = Sentence("names an entry that does not describe a used fluid")
        expected = Sentence('an entry with state = "used"')
        raise CatalogueError(problem, place=place, value=entry.used, expected=expected)
    return entry.used


def _falling(name: str, rows: list[ViscosityRow], data: Mapping[str, Any], origin: Origin) -> list[ViscosityRow]:
    """Sort rows by temperature and check that the viscosity falls with it."""
    ordered = sorted(enumerate(rows), key=lambda numbered: numbered[1].temperature_c)
    for (_, low), (number, high) in pairwise(ordered):
        if low.temperature_c == high.temperature_c:
            place = place_of((name, number, "temperature_c"), data, origin.file)
            raise CatalogueError(Sentence("temperature given twice"), place=place, value=low.temperature_c)
        if high.kinematic_viscosity_mm2_s >= low.kinematic_viscosity_mm2_s:
            raise CatalogueError(
                Sentence(
                    "viscosity must fall from {low:g} to {high:g} °C", low=low.temperature_c, high=high.temperature_c
                ),
                place=place_of((name, number, "kinematic_viscosity_mm2_s"), data, origin.file),
                value=high.kinematic_viscosity_mm2_s,
                expected=Sentence("less than {other:g} mm²/s", other=low.kinematic_viscosity_mm2_s),
            )
    return [row for _, row in ordered]


def _between_points(at: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Interpolate on straight lines; one line suffices where all of ``at`` lies between two neighbours."""
    if at.size and at.ndim:
        segment = int(np.clip(np.searchsorted(knots, at.min(), side="right") - 1, 0, len(knots) - 2))
        if at.min() >= knots[segment] and at.max() <= knots[segment + 1]:
            slope = (values[segment + 1] - values[segment]) / (knots[segment + 1] - knots[segment])
            line = at - knots[segment]
            line *= slope
            line += values[segment]
            return line
    return np.interp(at, knots, values)


def _plain(value: Any) -> Any:
    return float(value) if np.ndim(value) == 0 else value


class ViscosityTable(Strict):
    temperature_c: float = key("Temperature", ge=-60, le=200)
    kinematic_viscosity_mm2_s: float = key("Kinematic viscosity", "1 mm²/s is 1 cSt", width=22, ge=0.5, le=1e6)


class PropertyTable(ViscosityTable):
    density_g_cm3: float = key("Density", usual=usual.DENSITY_OF_TABLE, gt=0.5, lt=1.5)


class DensityTable(Strict):
    density_g_cm3: float = key("Density", "Such as 0.85", usual=usual.DENSITY, gt=0.5, lt=1.5)
    at_c: float = key("At", "15 °C unless stated", default=15.0, ge=-60, le=200)
    density_slope_g_cm3_k: float = key(
        "Slope",
        "Negative: −0.0007 is representative of transmission fluids",
        usual=usual.DENSITY_SLOPE,
        le=0,
        ge=-0.002,  # so that no density falls to nothing on the way to 150 °C
    )


ViscosityRow = TypeVar("ViscosityRow", bound=ViscosityTable)


class FluidFile(Entry):
    representative: list[str] = key("Representative", "What no data sheet gives, with commas between", default=[])
    study_regression: bool = key("Study's regression holds", "Of the source study's fluid alone", default=False)
    state: FluidState = key("State", "Of which the data are; fresh unless stated", default="fresh")
    used: str | None = key("Entry of the used fluid", "Id of a shipped entry with its data after use", default=None)
    pour_point_c: float | None = key(
        "Pour point", "Under it nothing is computed", usual=usual.POUR_POINT, default=None, ge=-80, le=20
    )
    density: DensityTable
    viscosity: list[ViscosityTable] = Field(min_length=2)
    table: list[PropertyTable] = []

    @field_validator("table")
    @classmethod
    def _two_rows(cls, rows: list[PropertyTable]) -> list[PropertyTable]:
        if len(rows) == 1:
            raise NotAccepted(Sentence("at least two temperatures, or no table"))
        return rows


FLUIDS = Shelf("fluids", FluidFile, _fluid)
checked_fluid, fluids = FLUIDS.checked, FLUIDS.usable


DEFAULT_FLUID = "hipol_atf_iid"
"""Taken for a unit whose file names no fluid."""


def load_fluid(id_or_path: str | Path) -> Fluid:
    """Load a fluid from its file.

    Parameters
    ----------
    id_or_path
        the id of one that is shipped or in the workshop's own catalogue, or the path of a file.

    Returns
    -------
    Fluid
        in the state that its data describe; ``doubts`` say what is unusual.

    Raises
    ------
    CatalogueError
        if the file is missing or wrong; the message names file, table, key and value, and lists every other fault.
    """
    return FLUIDS.load(id_or_path)
