"""Say what a person should know about a result: what is representative, assumed, left out or out of its range."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence

from atleak.catalogue.controller import Controller, NewOrigin
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.operating_point import HOT_IDLE, OperatingPoint
from atleak.catalogue.pump import Pump
from atleak.driven import Driven
from atleak.engine.leakage import narrow_gap_messages
from atleak.engine.profile import Profile
from atleak.engine.projection import Projection
from atleak.errors import Message
from atleak.readings import LandClearance, Readings
from atleak.rules import cannot_be
from atleak.sentence import Name, Sentence
from atleak.unit_systems import Quantity
from atleak.workshop_units import KPA


def _what_new_was(controller: Controller) -> Iterable[Message]:
    """Say what the mounting clearances are, where they are not those of these very pairs when new."""
    counts, lands = Counter(land.new_origin for land in controller.lands), len(controller.lands)
    of_origin = {
        NewOrigin.USED_UNIT: Sentence(
            "The mounting clearance of {count} of {lands} lands was measured on a used unit and is taken as new: wear "
            "counts from there.",
            count=counts[NewOrigin.USED_UNIT],
            lands=lands,
        ),
        NewOrigin.TYPE: Sentence(
            "The mounting clearance of {count} of {lands} lands is a value of the unit's type: how far single pairs "
            "differ from it counts in their wear.",
            count=counts[NewOrigin.TYPE],
            lands=lands,
        ),
        NewOrigin.RANGE: Sentence(
            "The mounting clearance of {count} of {lands} lands is known as a range only: wear counts from its upper "
            "end, flows when new from its mean cube.",
            count=counts[NewOrigin.RANGE],
            lands=lands,
        ),
    }
    for origin, text in of_origin.items():
        if counts[origin]:
            yield Message("info", f"mounting_clearance_{origin}", text)


def _about_pump(pump: Pump, profile: Profile, readings: Readings | None) -> Iterable[Message]:
    """Say what shares of a pump held at demand are of, what measured clearances do, and which are over their limit."""
    if pump.held_at_demand:
        text = Sentence(
            "The pump's displacement is held at demand: its capacity, all shares, its reserve and the speed from which "
            "it covers the leakage are those of its full stroke."
        )
        yield Message("info", "pump_full_stroke", text)
    if pump.counted.known and profile.pump_efficiency != "wilson":
        text = Sentence("The pump's measured clearances count nowhere: the profile takes its efficiency as a constant.")
        yield Message("warning", "pump_clearance_left_out", text)
    for name, missing in pump.left_out:
        if name == "side":
            text = Sentence(
                "The pump's side clearance was measured, but makes no slip here: {missing}.", missing=missing
            )
        else:
            text = Sentence(
                "The pump's tip clearance was measured, but makes no slip here: {missing}.", missing=missing
            )
        yield Message("warning", "pump_clearance_left_out", text)
    of_sheet = (None, None) if readings is None else readings.pump.um
    for name, um, most, in_head in zip(("side", "tip"), pump.measured.um, pump.limits.um, of_sheet, strict=True):
        if in_head is not None and um is not None and um != in_head:
            yield Message("warning", "pump_clearance_differs", _differs(name, in_head, um))
        if um is not None and most is not None and um > most:
            yield Message("warning", "pump_clearance_over_limit", _over_limit(name, um, most))
    if pump.counted.known and pump.as_new is None:
        text = Sentence(
            "The slip of the pump when new is not known, so that of the measured one stands beside no other."
        )
        yield Message("info", "pump_new_unknown", text)


def _differs(name: str, in_head: float, um: float) -> Sentence:
    values = {"of_head": Quantity(in_head, "clearance"), "of_job": Quantity(um, "clearance")}
    if name == "side":
        return Sentence(
            "The head of the sheet states a pump side clearance of {of_head:g} {of_head.unit}, the job {of_job:g} "
            "{of_job.unit}: the job's is taken.",
            **values,
        )
    return Sentence(
        "The head of the sheet states a pump tip clearance of {of_head:g} {of_head.unit}, the job {of_job:g} "
        "{of_job.unit}: the job's is taken.",
        **values,
    )


def _over_limit(name: str, um: float, most: float) -> Sentence:
    values = {"measured": Quantity(um, "clearance"), "most": Quantity(most, "clearance")}
    if name == "side":
        return Sentence(
            "The pump's side clearance of {measured:g} {measured.unit} is over the {most:g} {most.unit} that its "
            "manual allows.",
            **values,
        )
    return Sentence(
        "The pump's tip clearance of {measured:g} {measured.unit} is over the {most:g} {most.unit} that its manual "
        "allows.",
        **values,
    )


def _cannot_be(unworn: Iterable[Projection], points: Sequence[OperatingPoint]) -> Iterable[Message]:
    """Doubt a description by which a new unit cannot hold its pressure, and a condition set by hand, likewise."""
    lacking = [each for each in unworn if cannot_be(each)]
    own = {each.condition.label: _lack(each) for each in lacking if each.condition in points}
    if own:
        text = Sentence(
            "Not judged: the description of the unit cannot be right. With every land and its pump new it could not "
            "hold its pressure: {conditions}. Look at the pump's displacement, what consumers take, clearances (half "
            "of bore minus spool, in µm), diameters and pressures, and at temperature and speed where they were set "
            "by hand.",
            conditions=tuple(own.values()),
        )
        yield Message("warning", "description_impossible", text)
    by_hand = tuple(_lack(each) for each in lacking if each.condition not in points)
    if by_hand:
        text = Sentence(
            "Not judged at the condition set by hand, which no new unit holds: {conditions}.", conditions=by_hand
        )
        yield Message("warning", "condition_impossible", text)


def _lack(new: Projection) -> Sentence:
    values = {"condition": new.condition, "reserve": new.reserve}
    if not new.pressure_falls:
        return Sentence("at {condition} its pump supplies {reserve:.2f} times what is taken", **values)
    return Sentence(
        "{held:.0f} of {required:.0f} {required.unit} at {condition}, its pump supplying {reserve:.2f} "
        "times what is taken",
        held=Quantity(new.main_pressure_held * KPA, "pressure"),
        required=Quantity(new.condition.main_pressure * KPA, "pressure"),
        **values,
    )


def messages_of(
    readings: Readings | None,
    controller: Controller,
    fluid: Fluid,
    profile: Profile,
    projections: Sequence[Projection],
    drive: Driven,
    states: Iterable[LandClearance],
    unworn: Iterable[Projection],
) -> list[Message]:
    """Return the messages on inputs and projections, each once; those of gauges, log and uncertainty are not in it.

    Parameters
    ----------
    projections
        at every condition that is judged.
    drive
        what is known of a road test.
    states
        the clearance of every land.
    unworn
        at every condition that is judged, with every land new.
    """
    messages: list[Message] = [*_cannot_be(unworn, controller.operating_points), *controller.doubts, *fluid.doubts]
    if controller.representative:
        text = Sentence("{controller}: {what}", controller=Name(controller.name), what=Name(controller.representative))
        messages.append(Message("warning", "controller_representative", text))
    without = [land for land in controller.lands if land.key in controller.gaps_not_described]
    if 0 < len(without) < sum(not land.seal for land in controller.lands):
        text = Sentence(
            "{controller} names no gap of lands {lands}: they are taken to leak from main pressure to the sump in "
            "every gear, which is an upper bound.",
            controller=Name(controller.name),
            lands=[f"{land.component}/{land.land}" for land in without],
        )
        messages.append(Message("warning", "land_without_gap", text))
    sealed = [f"{land.component}/{land.land}" for land in controller.lands if land.seal]
    if sealed:
        text = Sentence(
            "A ring seals lands {lands}: they leak nothing through their clearance, which is not judged. What passes a "
            "ring is a leak of its own.",
            lands=sealed,
        )
        messages.append(Message("info", "land_sealed", text))
    gears = {projection.condition.gear for projection in projections}
    nowhere = [Name(circuit.name) for circuit in controller.circuits if not circuit.gears & gears]
    if nowhere:
        text = Sentence("No operating point applies {circuits}: what they hold is judged nowhere.", circuits=nowhere)
        messages.append(Message("warning", "circuit_nowhere_applied", text))
    messages += _what_new_was(controller)
    messages += _about_pump(controller.pump, profile, readings)
    if readings is None:
        text = Sentence("No measuring sheet: every land is computed at its mounting clearance.")
        messages.append(Message("warning", "no_readings", text))
    else:
        messages += readings.messages
    for state in states:
        messages += state.messages
    temperatures = [projection.condition.temperature for projection in projections]
    road = drive.road
    if drive.log is not None and road is not None:
        temperatures += drive.log.temperatures or ()
    messages += fluid.messages(min(temperatures), max(temperatures), profile.viscosity)
    messages += narrow_gap_messages(gap for projection in projections for gap in projection.gaps)
    for projection in projections:
        messages += projection.messages
        if projection.pump_capacity <= 0.0:
            text = Sentence(
                "{condition}: the pump delivers nothing at this pressure and viscosity.",
                condition=projection.condition,
            )
            messages.append(Message("warning", "pump_delivers_nothing", text))
    if all(projection.condition.name != HOT_IDLE for projection in projections):
        text = Sentence(
            "{controller} states no operating point hot_idle, where a worn unit fails first.",
            controller=Name(controller.name),
        )
        messages.append(Message("info", "no_hot_idle", text))
    if road is not None:
        messages += road.road_test.messages
        messages += road.messages
    return list(dict.fromkeys(messages))
