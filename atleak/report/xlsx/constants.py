"""Write the sheet of constants: every number of the formulas stands there once, by its name, with unit and source.

What a formula may hold itself is what its equation is made of: small integers, and factors between units.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from xlsxwriter.worksheet import Worksheet

from atleak.catalogue.circuits import Leak, Pressure
from atleak.catalogue.controller import REFERENCE_TEMPERATURE, Controller, Gap
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import ROUNDING
from atleak.catalogue.pump import TIP_DENSITY, Pump, TipGaps
from atleak.common.sentences import Name, Sentence
from atleak.common.units import DM3_MIN, G_CM3, KPA, MPA_S, UM, Quantity, UnitOf
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import Assumptions, UnitUncertainty
from atleak.diagnosis.uncertainty.sources import AVERAGED_FROM, ENOUGH_DEGREES, STEP_TOLERANCE, TOLERANCE_HOLDS
from atleak.engine.leakage import GapLaw
from atleak.engine.profile import UNKNOWN
from atleak.equations.fluid import ABSOLUTE_ZERO, ASTM_D341_SHIFT, STUDY_DENSITY, STUDY_VISCOSITY
from atleak.equations.gap import ECCENTRIC_GAIN, ENTRY_AND_EXIT_LOSS, FULLY_ECCENTRIC, MEAN_ECCENTRIC
from atleak.measurements.clearances import REPEAT_TOLERANCE
from atleak.report.xlsx import live_sheet as names
from atleak.report.xlsx.book import NO_DELIVERY, ReportBook
from atleak.report.xlsx.live_sheet import (
    AFTER_A_NUMBER,
    CLEARANCE,
    FLOW,
    PRESSURE,
    TEMPERATURE,
    NamedQuantity,
    constant_pressure,
    of_leak,
    of_relation,
    of_tips,
    share_of_pressure,
)
from atleak.report.xlsx.page import SheetPage

CONSTANTS = Sentence("Constants")
ORDERED_BELOW = 900_000.0  # share [%] that still tells two totals of a band apart
_CHOICE = Sentence("choice of this project")
_PAPER = "Energies 2023, 16, 7667, eq. (5)"
_WHITE = "White F. M., Fluid Mechanics, 7th ed., McGraw-Hill 2011, section 6.9"
_ZERO = Quantity(0.0, "temperature")
_PROGRAM = Sentence("a mark of this workbook, not a quantity")


def _constant(
    name: str, label: Sentence, unit: str | UnitOf, value: float, source: str, formula: str | None = None
) -> NamedQuantity:
    return NamedQuantity(name, label, unit, "plain", value, formula, source=source)


class ConstantCells:
    """The constants of one diagnosis, and the sheet on which they stand."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self.lines = list({each.name: each for each in _constants(diagnosis)}.values())

    def write(self, book: ReportBook, sheet: Worksheet) -> None:
        """Write a row for every constant and give its cell the name by which formulas ask for it."""
        headings = (Sentence("name"), Sentence("constant"), Sentence("value"), Sentence("unit"), Sentence("source"))
        page = SheetPage(book, sheet, (32, 70, 16, 12, 80))
        page.headings(0, headings)
        for row, each in enumerate(self.lines, start=1):
            book.put(sheet, row, 0, each.name)
            page.text(row, 1, each.label)
            each.write(book, sheet, row, 2, each.name)
            book.put(sheet, row, 3, each.unit, book.form(**AFTER_A_NUMBER))
            page.text(row, 4, each.source)


def _constants(diagnosis: Diagnosis) -> Iterable[NamedQuantity]:
    controller, law = diagnosis.controller, diagnosis.model.law
    reference = Sentence("reference temperature of diameters and clearances")
    yield _constant(names.REFERENCE, reference, TEMPERATURE, REFERENCE_TEMPERATURE, "ISO 1:2022")
    yield from _of_gaps(diagnosis, law)
    yield from _of_fluid(diagnosis.fluid, diagnosis.profile.viscosity)
    yield from _of_pressures(controller)
    for number, leak in enumerate(controller.leaks, start=1):
        yield from _of_leak(number, leak)
    if diagnosis.model.uses_slip:
        pump = controller.pump
        for end, each in (("", pump), ("_new", pump.as_new)):
            yield from _of_tips(each, end, controller) if each is not None else ()
    if diagnosis.measured_at is not None and diagnosis.uncertainty is not None:
        at, stated = diagnosis.measured_at, Sentence("as stated for the job")
        origin = Sentence("nobody stated it") if at.assumed else stated
        measured = Sentence("temperature of gauge and parts when measured")
        yield _constant(names.MEASURED_AT, measured, TEMPERATURE, at.value, origin)
        yield from _of_uncertainty(diagnosis.uncertainty)
    rounded = Sentence("relative: a value that equals its limit but for floating point has reached it")
    yield NamedQuantity(names.ROUNDING_NAME, rounded, "", "scientific", ROUNDING, fixed=True, source=_CHOICE)
    never = Sentence("stands for an infinite share, of a pump that delivers nothing")
    yield NamedQuantity(names.NOTHING_DELIVERED, never, "%", "scientific", NO_DELIVERY, fixed=True, source=_PROGRAM)
    largest = Sentence("largest share that still tells two totals of a band apart")
    yield NamedQuantity(names.LARGEST_SHARE, largest, "%", "plain", ORDERED_BELOW, fixed=True, source=_PROGRAM)


def _of_gaps(diagnosis: Diagnosis, law: GapLaw) -> Iterable[NamedQuantity]:
    gain = Sentence("what the square of the relative eccentricity e/c adds to the flow")
    yield _constant(names.GAIN, gain, "", ECCENTRIC_GAIN, _PAPER)
    eccentricity = diagnosis.profile.eccentricity
    if eccentricity == UNKNOWN:
        mean = Sentence("factor of the flow, mean over all positions of the spool")
        yield _constant(names.MEAN_OF_POSITIONS, mean, "", MEAN_ECCENTRIC, _PAPER, f"1+{names.GAIN}/3")
    elif eccentricity:
        taken = Sentence("relative eccentricity e/c that every spool is taken to have")
        yield _constant(names.ECCENTRICITY, taken, "", eccentricity, Sentence("option of the profile"))
    fully = Sentence("factor of the flow of a spool that touches its bore")
    yield _constant(names.FULLY, fully, "", FULLY_ECCENTRIC, _PAPER, f"1+{names.GAIN}")
    if not law.linear:
        loss = Sentence("loss at entry and exit of a gap, in velocity heads")
        yield _constant(names.ENTRY_LOSS, loss, "", ENTRY_AND_EXIT_LOSS, _WHITE)


def _of_fluid(fluid: Fluid, model: str) -> Iterable[NamedQuantity]:
    if model == "d341":
        a, b = fluid.d341
        points = Sentence("through two points of {source}", source=Name(fluid.source))
        yield _constant(names.D341_A, Sentence("A of the line log log (ν + 0.7) = A − B log T"), "", a, points)
        yield _constant(names.D341_B, Sentence("B of the same line"), "", b, points)
        shift = Sentence("what is added to ν [{unit}] before taking logarithms", unit=UnitOf("viscosity"))
        yield _constant(names.D341_SHIFT, shift, UnitOf("viscosity"), ASTM_D341_SHIFT, "ASTM D341")
        zero = Sentence("temperature of {zero:g} {zero.unit} above absolute zero", zero=_ZERO)
        yield _constant(names.ABSOLUTE, zero, UnitOf("above_absolute_zero"), -ABSOLUTE_ZERO, "ISO 80000-5")
        (at, density), sheet = fluid.density_at, Name(fluid.source)
        stated, there = Sentence("temperature at which the density is stated"), Sentence("density at that temperature")
        yield _constant(names.DENSITY_AT, stated, TEMPERATURE, at, sheet)
        yield _constant(names.DENSITY_NAME, there, UnitOf("density"), density * G_CM3, sheet)
        slope, per_kelvin = Sentence("change of the density with temperature"), UnitOf("density_per_kelvin")
        yield _constant(names.DENSITY_SLOPE_NAME, slope, per_kelvin, fluid.density_slope * G_CM3, sheet)
    elif model == "regression":
        viscosity = Sentence("kinematic viscosity of the study's regression at {zero:g} {zero.unit}", zero=_ZERO)
        density_at_zero = Sentence("density of the study's regression at {zero:g} {zero.unit}", zero=_ZERO)
        labels = (
            (viscosity, UnitOf("viscosity"), STUDY_VISCOSITY[0]),
            (Sentence("its exponent with temperature"), UnitOf("per_kelvin"), STUDY_VISCOSITY[1]),
            (density_at_zero, UnitOf("density"), STUDY_DENSITY[0] * G_CM3),
            (Sentence("its change with temperature"), UnitOf("density_per_kelvin"), STUDY_DENSITY[1] * G_CM3),
        )
        for name, (label, unit, value) in zip(names.STUDY_NAMES, labels, strict=True):
            source = Sentence("the source study's regressions, eqs. (29) and (30)")
            yield _constant(name, label, unit, value, source)


def fluid_formulas(model: str, temperature: str) -> tuple[str | None, str | None]:
    """Return the formulas of kinematic viscosity and density by the constants of their model; none of a table."""
    if model == "d341":
        viscosity = f"10^(10^({names.D341_A}-{names.D341_B}*LOG10({temperature}+{names.ABSOLUTE})))-{names.D341_SHIFT}"
        return viscosity, f"{names.DENSITY_NAME}+{names.DENSITY_SLOPE_NAME}*({temperature}-{names.DENSITY_AT})"
    if model == "regression":
        nu, exponent, rho, per_kelvin = names.STUDY_NAMES
        return f"{nu}*EXP({exponent}*{temperature})", f"{per_kelvin}*{temperature}+{rho}"
    return None, None


def _of_pressures(controller: Controller) -> Iterable[NamedQuantity]:
    """Return what pressures follow from others by, and the shares of them and steady pressures that gaps see."""
    file = Sentence("the valve body's file: {source}", source=Name(controller.source))
    for section in ("p_s", "p_m"):
        relation = controller.relations[section]
        of = {"section": section}
        ratio = Sentence("{section} per p_g", **of)
        yield _constant(of_relation(section, "ratio"), ratio, "", relation.ratio, file)
        offset = Sentence("{section} where p_g is nothing", **of)
        yield _constant(of_relation(section, "offset"), offset, PRESSURE, relation.offset * KPA, file)
        if relation.limit is not None:
            most = Sentence("{section} at most", **of)
            yield _constant(of_relation(section, "limit"), most, PRESSURE, relation.limit * KPA, file)
    leaking: list[Gap | Leak] = [*controller.gaps, *controller.leaks]
    ends = [end for each in leaking for end in (each.high, each.low)]
    for pressure in sorted(set(ends), key=str):
        yield from _of_pressure(pressure, file)


def _of_pressure(pressure: Pressure, file: str) -> Iterable[NamedQuantity]:
    if pressure.section is None:
        if pressure.constant:
            steady = Sentence("pressure that stays the same")
            yield _constant(constant_pressure(pressure), steady, PRESSURE, pressure.constant * KPA, file)
    elif pressure.coefficient != 1.0:
        share = Sentence("share of a section's pressure that a gap or leak sees")
        yield _constant(share_of_pressure(pressure), share, "", pressure.coefficient, file)


def _of_leak(number: int, leak: Leak) -> Iterable[NamedQuantity]:
    of: dict[str, Any] = {"name": Name(leak.name)}
    flow, at = Sentence("leak {name}: flow", **of), Sentence("leak {name}: pressure drop at that flow", **of)
    yield _constant(of_leak(number, "flow"), flow, FLOW, leak.flow * DM3_MIN, Name(leak.source))
    yield _constant(of_leak(number, "drop"), at, PRESSURE, leak.pressure_drop * KPA, Name(leak.source))
    if leak.viscosity is not None:
        viscosity, unit = Sentence("leak {name}: dynamic viscosity at that flow", **of), UnitOf("dynamic_viscosity")
        yield _constant(of_leak(number, "viscosity"), viscosity, unit, leak.viscosity * MPA_S, Name(leak.source))
    else:
        density = Sentence("leak {name}: density at that flow", **of)
        yield _constant(of_leak(number, "density"), density, UnitOf("density"), leak.density * G_CM3, Name(leak.source))


def _of_tips(pump: Pump, end: str, controller: Controller) -> Iterable[NamedQuantity]:
    file = Sentence("the valve body's file: {source}", source=Name(controller.source))
    for number, (_, size) in enumerate(pump.tips if pump.gaps.tips is not None else (), start=1):
        assert pump.gaps.tips is not None
        conductance, bend = _tip_slip(pump.gaps.tips, size)
        slips = Sentence(
            "slip over the pump's tips at {size:g} {size.unit}, for each {pressure} at 1 {viscosity}",
            size=Quantity(size * UM, "clearance"),
            pressure=PRESSURE,
            viscosity=UnitOf("dynamic_viscosity"),
        )
        yield _constant(of_tips(end, number, "conductance"), slips, UnitOf("tip_slip"), conductance, file)
        bends = Sentence("how the loss at entry and exit bends that slip")
        yield _constant(of_tips(end, number, "bend"), bends, UnitOf("tip_bend"), bend, _WHITE)


def _tip_slip(tips: TipGaps, clearance: float) -> tuple[float, float]:
    """Return what slips over a pump's tips [dm³/min] for each kPa at 1 mPa·s, and how the entry loss bends that."""
    per_viscous = clearance**2 / (12.0 * tips.land * 1e-3)  # of one mPa·s
    conductance = tips.rims * tips.width * clearance * per_viscous / tips.in_a_row * 1e3 * DM3_MIN  # per kPa
    return conductance, 2.0 * ENTRY_AND_EXIT_LOSS * TIP_DENSITY * per_viscous**2 / tips.in_a_row * 1e3


def _of_uncertainty(uncertainty: UnitUncertainty) -> Iterable[NamedQuantity]:
    """Return what the budgets rest on besides instruments and readings."""
    assumed: Assumptions = uncertainty.assumptions
    settable = Sentence("default of this project, or set by the workshop")
    # fmt: off
    rows: tuple[tuple[str, Sentence, str | UnitOf, float, str], ...] = (
        (names.COVERAGE_NAME, Sentence("coverage of the expanded uncertainty U"), "", uncertainty.coverage, settable),
        (names.ROOM_TEMPERATURE, Sentence("half width of the temperature of measuring"), UnitOf("kelvin"),
         assumed.room_temperature, settable),
        (names.FORM_RESIDUAL, Sentence("part of ovality and taper that is kept as uncertain"), "",
         assumed.form_residual, settable),
        (names.UNSEEN_OVALITY, Sentence("ovality of a part where no land shows it"), CLEARANCE,
         assumed.unseen_ovality * UM, settable),
        (names.NOMINAL_DIAMETER, Sentence("u of a diameter not measured"), CLEARANCE,
         assumed.nominal_diameter * UM, settable),
        (names.OWN_MOUNTING, Sentence("u of a mounting clearance of this one pair"), CLEARANCE,
         assumed.mounting_clearance * UM, settable),
        (names.TOLERANCE_COVERAGE, Sentence("part of the pairs that a tolerance of c_m holds"), "", TOLERANCE_HOLDS,
         _CHOICE),
        (names.REPEATS_APART, Sentence("repeats further apart count as if they were so far apart"), CLEARANCE,
         REPEAT_TOLERANCE * UM, _CHOICE),
        (names.VISIBLE_STEP, Sentence("spread or step that is taken as nothing"), CLEARANCE, STEP_TOLERANCE * UM,
         _CHOICE),
        (names.AVERAGED, Sentence("spread per step from which on repeats average rounding out"), "", AVERAGED_FROM,
         _CHOICE),
        (names.TRUSTED_DEGREES, Sentence("degrees of freedom from which on repeats are trusted alone"), "",
         ENOUGH_DEGREES, _CHOICE),
    )
    # fmt: on
    return [_constant(*row) for row in rows]
