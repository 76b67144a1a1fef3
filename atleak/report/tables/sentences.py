"""Sentences that terminal, pages, workbook and PDF share: on verdicts, rules, pressures, what is provisional."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from atleak.analysis.pressures import HeldPressure, PressuresAt, drawing_more, pressures_at
from atleak.catalogue.controller import REFERENCE_TEMPERATURE
from atleak.catalogue.fluid import USED_THINNER
from atleak.catalogue.limits import RuleKind
from atleak.catalogue.repairs import LandKey
from atleak.common.units import DM3_MIN, KPA, PERCENT
from atleak.common.wording import Wording, isolated
from atleak.diagnosis.consequence import Consequence
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import Crossing, LandDiagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.profile import PROFILES, UNKNOWN, Profile
from atleak.engine.projection import Projection
from atleak.report.tables.assumed import assumed_line
from atleak.report.tables.names import land_number, land_words, position_band


def caveat_marks(diagnosis: Diagnosis, say: Wording) -> list[str]:
    """Return the words that stand beside the verdict: that it is provisional, that leakage is an upper bound."""
    marks = ["provisional"] if diagnosis.provisional else []
    marks += ["upper_bound"] if diagnosis.upper_bound else []
    return [say.get("caveat_marks", mark) for mark in marks]


def caveats(diagnosis: Diagnosis, say: Wording) -> list[str]:
    """Say which values are assumed and whether they would change the verdict, and that leakage is an upper bound."""
    sentences = [assumed_line(diagnosis, say)]
    if diagnosis.upper_bound:
        sentences.append(say("caveats.upper_bound"))
    return sentences


LOOK_FIRST = 3  # lands that are named where a pressure decided
_SHOWS = 0.05  # [dm³/min] a lack that one decimal shows


def counted_in_speed(diagnosis: Diagnosis, say: Wording) -> str:
    """Say which consumers are in the lowest engine speed that the pump needs: none where the file states none.

    Of a pump held at demand it says too that the speed is that of the full stroke.
    """
    consumers = ", ".join(isolated(say.name(each.name)) for each in diagnosis.controller.consumers)
    said = say("texts.counted_in_speed", consumers=consumers) if consumers else say("texts.left_out_of_speed")
    return f"{said}. {say('pump.full_stroke')}" if diagnosis.controller.pump.held_at_demand else said


def decision_words(decision: str, probability: float | None, say: Wording) -> str:
    """Return how sure a verdict is, with the probability that the true value is past the limit: ``fail (100 %)``."""
    words = say.get("decisions", decision)
    return words if probability is None else f"{words} ({say.percent(probability, 0)})"


def full_stroke(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say that shares, reserve and speed are of the full stroke; None for a pump whose stroke is fixed."""
    return f"{say('pump.full_stroke')}." if diagnosis.controller.pump.held_at_demand else None


def fluid_in_state(diagnosis: Diagnosis, say: Wording) -> str:
    """Return the name of the fluid, its state, and whether it is not the one required: ``Mobil ATF 220; used``."""
    fluid, (low, high) = diagnosis.fluid, USED_THINNER
    state = "fresh_assumed" if diagnosis.fluid_state_assumed else "used_estimated" if fluid.estimated else fluid.state
    said = f"{isolated(say.name(fluid.name))}; {say(f'fluid_states.{state}', low=low, high=high)}"
    required = diagnosis.controller.fluid
    choice = "required" if required is None else required.choice(fluid)
    if required is None or choice == "required":
        return said
    return f"{said}; {say(f'fluid_states.{choice}', required=isolated(say.name(required.required)))}"


def profile_words(profile: Profile, say: Wording) -> str:
    """Return the name of a profile and what was set apart from it: ``paper (Pump efficiency: Wilson slip)``."""
    base, name = PROFILES[profile.name].options, say.get("profile_names", profile.name)
    changed = {option: value for option, value in profile.options.items() if base[option] != value}
    return f"{name} ({'; '.join(option_words(changed, say))})" if changed else name


def option_words(options: Mapping[str, Any], say: Wording) -> list[str]:
    """Return options of a profile in words: ``Pump efficiency: Wilson slip``."""
    return [f"{say(f'options.{name}')}: {option_value(name, value, say)}" for name, value in options.items()]


def option_value(name: str, value: Any, say: Wording) -> str:
    """Return the value of an option of a profile in words."""
    if not isinstance(value, str):
        return say.plain(value)
    return say.get("option_values", f"{name}_{value}" if name == "circuits" else value)


def measuring_temperature(diagnosis: Diagnosis, say: Wording) -> str:
    """Say at which temperature gauge and parts were measured: assumed, as stated, or corrected for; "" without a sheet.

    In English ``35 °C, diameters corrected to 20 °C``.
    """
    measured_at = diagnosis.measured_at
    if measured_at is None:
        return ""
    said = "assumed" if measured_at.assumed else "corrected" if measured_at.corrects else "stated"
    values = {
        "temperature": say.plain_value(measured_at.value, "temperature"),
        "reference": say.plain_value(REFERENCE_TEMPERATURE, "temperature"),
    }
    return say(f"facts.temperature_{said}", **values)


def readings_in_doubt(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say which measured lands are tighter than new ones can be, and which have repeats that disagree; None without."""
    tight = sum(land.suspect for land in diagnosis.lands)
    apart = [land_number(diagnosis.controller, land.key, say) for land in diagnosis.lands if land.state.doubts]
    said = [say("sentences.tighter_than_new", count=tight)] if tight else []
    said += [say("sentences.repeats_apart", lands=", ".join(apart))] if apart else []
    return " ".join(said) or None


def wear_words(land: LandDiagnosis, say: Wording, *, unit: bool = True) -> str:
    """Return the wear, with its unit or below one; that there is none of a clearance that new pairs have."""
    if land.within_new:
        return say("texts.within_new")
    worn = say.number(None if land.wear is None else land.wear * PERCENT, 0)
    return worn if land.wear is None or not unit else say.percent(land.wear, 0)


def replace_at(land: LandDiagnosis, say: Wording) -> str | None:
    """Say at which mileage the land reaches the wear limit for replacing; None where none is projected."""
    return None if land.replace_mileage is None else crossing_in_words(land.replace_mileage, say)


def consequence_words(diagnosis: Diagnosis, land: LandDiagnosis, say: Wording) -> str | None:
    """Say what the wear of a land does to its unit, and up to which mileage that is known; None of a sound land."""
    consequence = diagnosis.consequences[land.key]
    if not land.verdict.flagged and consequence in (Consequence.NONE, Consequence.UNKNOWN):
        return None
    service = None if consequence is Consequence.NOW else diagnosis.next_service(land)
    key = "none_until" if consequence is Consequence.NONE and service else str(consequence)
    return say(f"consequences.{key}", mileage=service_mileage(service, say) if service else "")


def service_mileage(mileage: float, say: Wording) -> str:
    """Return the mileage of a service [km] in the reader's unit, in whole thousands."""
    return say.number(1000.0 * math.floor(say.convert(mileage, "distance") / 1000.0), 0)


def nothing_now(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say that nothing has to be repaired now though lands are worn past a limit; None where something has."""
    waits = diagnosis.verdict.calls_for_repair and not diagnosis.urgency.calls_for_repair
    return say("consequences.nothing_now") if waits else None


def rule_value(value: float, kind: RuleKind, say: Wording) -> str:
    """Return what a rule judged, or its limit, with its unit: ``12.5 %``, ``18.0 µm``."""
    carried = value * kind.factor
    if kind.quantity is not None:
        return say.quantity(carried, kind.quantity, 1)
    return f"{say.number(carried, 1)}\u00a0{kind.unit}".rstrip()


def crossing_in_words(at: Crossing, say: Wording) -> str:
    """Say at which mileage a limit is reached, to two digits, or before which it is not; no number nobody can foresee.

    ``160 000 km (140 000 to 180 000)``, ``not before 140 000 km``, ``not foreseeable``. What two digits would put
    before the vehicle's present mileage stands in full.
    """
    present = say.convert(at.present, "distance")
    if at.foreseeable:
        shown = (say.convert(each, "distance") for each in (at.value, at.low, at.high))
        ends = ((each, float(f"{each:.2g}")) for each in shown)
        value, low, high = (say.number(each if short < present else short, 0) for each, short in ends)
        return say("texts.replace_between", value=value, low=low, high=high)
    if at.not_before is None:
        return say("texts.not_foreseeable")
    not_before = say.convert(at.not_before, "distance")
    step = 10.0 ** (math.floor(math.log10(not_before)) - 1)
    short = math.floor(not_before / step) * step
    return say("texts.not_before", mileage=say.number(not_before if short < present else short, 0))


def when_new(diagnosis: Diagnosis, projection: Projection, growth: float) -> str:
    """Say in English what the same unit draws new, and with pairs as wide as these may have been; how it has grown."""
    new, unworn = (each.share * PERCENT for each in (diagnosis.new_at(projection), diagnosis.unworn_at(projection)))
    if f"{unworn:.1f}" == f"{new:.1f}":
        return f"{new:.1f} % when new, {_grown(growth)}"
    as_wide = f"{unworn:.1f} % with new pairs as wide as these may have been"
    return f"{new:.1f} % when new, {as_wide}: {_grown(growth)} over that"


def _grown(growth: float) -> str:
    if abs(growth) < 0.5 / PERCENT:
        return "not grown"
    return f"grown by {growth * PERCENT:.0f} %" if growth >= 0.0 else f"{-growth * PERCENT:.0f} % less than new"


def position_sentence(diagnosis: Diagnosis, projection: Projection, say: Wording) -> str:
    """Say for which position of the spools flows are given, and the share as they may lie; "" where there is none."""
    band = position_band(diagnosis, projection)
    if band is None or projection.pump_capacity <= 0.0:
        return ""
    low, high = (say.percent(each, 0 if band[1] >= 0.1 else 1) for each in band)
    key = "anywhere" if diagnosis.profile.eccentricity == UNKNOWN else "concentric"
    return say(f"sentences.{key}", condition=say.condition(projection.condition), low=low, high=high)


# --- pressures


def land_in_words(diagnosis: Diagnosis, key: LandKey, say: Wording) -> str:
    """Name a land: ``25/1 main pressure valve``."""
    return land_words(diagnosis.controller, key, say)


def unsolved(diagnosis: Diagnosis, say: Wording) -> str | None:
    """Say that the valve body's file describes no circuits, or that none is solved; None where they are."""
    if diagnosis.profile.circuits != "on":
        return say("held.not_solved")
    return None if diagnosis.controller.circuits else say("held.no_circuits")


def pressure_sentence(at: PressuresAt, say: Wording) -> str:
    """Say what main pressure holds at a condition, and what is permissible there."""
    line, point = at.line, at.projection.condition
    falls = at.projection.pressure_falls
    sentence = say(
        f"held.line_{'given' if not at.solved else 'falls' if falls else 'holds'}",
        condition=say.condition(point),
        required=_kpa(point.main_pressure, say),
        held=_kpa(line.now, say),
        new=_kpa(line.new, say),
        interval=_interval(line.interval, KPA, "pressure", 0, say, "interval"),
    )
    parts = [sentence]
    if falls and at.projection.reserve >= 1.0 and at.followed is not None and at.followed.circuit is not None:
        held, new = _kpa(at.followed.now, say), _kpa(at.followed.new, say)
        parts.append(say("held.follows", circuit=say.name(at.followed.circuit.name), held=held, new=new))
    return " ".join(filter(None, (*parts, permissible_words(line, say))))


def permissible_words(line: HeldPressure, say: Wording) -> str:
    """Say which main pressure is permissible, and that less is required; an empty text where the file does not say."""
    low, high = (line.permissible.low, line.permissible.high) if line.permissible else (None, None)
    if low is None:
        return "" if high is None else say("held.permissible_to", high=_kpa(high, say))
    if high is None:
        said = say("held.permissible_from", low=_kpa(low, say))
    else:
        said = say("held.permissible_between", low=_kpa(low, say), high=_kpa(high, say))
    return f"{said} {say('held.requires_less')}" if line.low is None else said


def reserve_sentence(at: PressuresAt, say: Wording) -> str:
    """Say how many times the pump supplies what is taken from it, and what consumers lack."""
    sentence = say(
        "held.reserve",
        reserve=say.number(at.projection.reserve, 2),
        new=say.number(at.reserve_new, 2),
        interval=_interval(at.reserve_interval, 1.0, "number", 2, say, "interval"),
    )
    starved = at.projection.starved * DM3_MIN
    return f"{sentence} {say('held.starved', flow=say.value(starved, 'flow', 1))}" if starved >= _SHOWS else sentence


def circuit_sentence(diagnosis: Diagnosis, held: HeldPressure, say: Wording) -> str:
    """Say what a circuit holds, of what when new, how that is judged, and which lands cost it that."""
    name = say.name(held.circuit.name) if held.circuit else say("held.line")
    sentence = say(
        "held.circuit",
        circuit=name,
        held=_kpa(held.now, say),
        new=_kpa(held.new, say),
        interval=_interval(held.interval, KPA, "pressure", 0, say, "between"),
    )
    words = [] if held.verdict is None else [say.signed(held.verdict)]
    if held.verdict is not None and held.verdict.flagged:
        kind = "held.costs" if held.loss > 0.0 else "held.raises"
        words += [
            say(kind, land=land_in_words(diagnosis, key, say), loss=_kpa(abs(loss), say)) for key, loss in held.costly
        ]
    return f"{sentence}: {'; '.join(words)}" if words else sentence


def because_of(diagnosis: Diagnosis, rule: Rule, say: Wording) -> str | None:
    """Say which pressure or reserve decided, with its numbers and the lands to look at; None for any other rule."""
    if rule.kind not in _BECAUSE_OF or rule.condition is None or rule.new is None:
        return None
    at = pressures_at(diagnosis, diagnosis.at(rule.condition))
    held = next((each for each in at.applied if each.rule == rule), at.line if rule == at.reserve_rule else None)
    if held is None:
        return None
    keys = [key for key, _ in held.costly]
    if rule.kind is RuleKind.RESERVE and not rule.probable:
        keys = [] if rule in diagnosis.pump.lacking else list(drawing_more(diagnosis, at.projection))
    because = may_be(diagnosis, rule, say) if rule.probable else _by_rule(rule, held, say)
    said = [f"{because or ''}."]
    if _kept_by_pump(diagnosis, rule):
        keys = [land.key for land in diagnosis.flagged if land.key in keys]
        said.append(say("pump.new_does"))
    if keys:
        lands = ", ".join(land_in_words(diagnosis, key, say) for key in keys[:LOOK_FIRST])
        said.append(say("held.look_first", lands=lands))
    return " ".join(said)


def _kept_by_pump(diagnosis: Diagnosis, rule: Rule) -> bool:
    """Tell whether a new pump would keep a rule that is past its limit, though this one is within its own."""
    new = None if diagnosis.pump.verdict.flagged else diagnosis.pump_new
    return new is not None and any(each.id == rule.id and not each.verdict.flagged for each in new.unit_rules)


def _by_rule(rule: Rule, held: HeldPressure, say: Wording) -> str:
    """Say the numbers of a rule past its limit: a reserve, the line's permissible pressure, or what a circuit lost."""
    values = {"condition": say.condition(rule.condition) if rule.condition else "", "held": _kpa(held.now, say)}
    if rule.kind is RuleKind.RESERVE:
        reserve, limit = say.number(rule.value, 2), say.number(rule.limit, 2)
        return say("held.by_reserve", reserve=reserve, limit=limit, **values)
    if rule.kind is RuleKind.PERMISSIBLE_PRESSURE:
        return say("held.by_permissible", low=_kpa(held.low or 0.0, say), **values)
    circuit = say.name(rule.circuit.name) if rule.circuit else ""
    kind = "held.by_circuit" if rule.new is None or held.now <= rule.new else "held.by_rise"
    return say(kind, circuit=circuit, new=_kpa(held.new, say), **values)


def may_be(diagnosis: Diagnosis, rule: Rule, say: Wording) -> str | None:
    """Say how far a reserve or a pressure may be from what is computed, and the line with it; None of any other rule.

    That is the end of its 95 % interval on the side of the limit.
    """
    if rule.kind not in _BECAUSE_OF or rule.condition is None:
        return None
    at = pressures_at(diagnosis, diagnosis.at(rule.condition))
    values = {"condition": say.condition(rule.condition)}
    if rule == at.reserve_rule:
        return say("held.may_reserve", low=say.number((at.reserve_interval or (math.nan,))[0], 2), **values)
    held = next((each for each in at.applied if each.rule == rule), None)
    if held is None or held.interval is None:
        return None
    low, high = held.interval
    name = say.name(held.circuit.name) if held.circuit else say("held.line")
    if high - held.new > held.new - low:
        return say("held.may_rise", circuit=name, high=_kpa(high, say), **values)
    said, line = say("held.may_fall", circuit=name, low=_kpa(low, say), **values), at.line.interval
    falls = held is not at.line and line is not None and line[0] < _LESS * at.line.now
    return say("held.then_line", said=said, line=_kpa(line[0], say)) if falls and line is not None else said


_LESS = 0.95  # of the line pressure, under which its fall is said: choice of this project
_BECAUSE_OF = (RuleKind.RESERVE, RuleKind.CIRCUIT_LOSS, RuleKind.PERMISSIBLE_PRESSURE)


def _kpa(pressure: float, say: Wording) -> str:
    return say.value(pressure * KPA, "pressure", 0)


def _interval(
    interval: tuple[float, float] | None, factor: float, kind: str, digits: int, say: Wording, words: str
) -> str:
    """Return an interval in words; an empty text where nothing is known of it or it is narrower than what is shown."""
    if interval is None:
        return ""
    low, high = (say.value(end * factor, kind, digits) for end in interval)
    return "" if low == high else say(f"held.{words}", low=low, high=high)


def shares_add_up(diagnosis: Diagnosis, say: Wording) -> str:
    """Say that the shares of the lands add up to the total, or what is to be added to them at each condition."""
    shown = diagnosis.presented
    others = (f"{say.percent(each.share_of(each.other_leakage))} ({say.condition(each.condition)})" for each in shown)
    if any(each.other_leakage for each in shown):
        added = say("texts.shares_and_others", others=", ".join(others))
    else:
        added = say("texts.shares_add_up")
    return " ".join(filter(None, (added, full_stroke(diagnosis, say))))


_KINDS = {"µm": "clearance", "kPa": "pressure"}  # kind of quantity by the unit in which rules are recorded


def rule_quantity(rule: Rule, value: float, say: Wording) -> str:
    """Return a value of a rule, in SI or as a fraction, in the reader's unit."""
    unit = rule.kind.unit
    if unit in _KINDS:
        return say.quantity(value * rule.kind.factor, _KINDS[unit])
    return say.percent(value) if unit else say.number(value, 2)


def rule_name(rule: Rule, say: Wording, *, brief: bool = False) -> str:
    """Return what a rule limits, of which circuit and at which condition; ``brief``, a share's name is one word."""
    if brief and rule.kind.is_share and rule.condition is not None:
        return say("rules.share_at", condition=say.condition(rule.condition))
    return ", ".join(filter(None, (rule_limited(rule, say), *_where(rule, say))))


def rule_reached(rule: Rule, say: Wording) -> str:
    """Return a rule with its value, the limit and where that was: ``wear 60.1 % (limit 30 %)``."""
    value = rule_quantity(rule, rule.value, say) if math.isfinite(rule.value) else say.number(rule.value, 0)
    limit = rule_quantity(rule, rule.limit, say)
    key = "probable" if rule.probable and rule.verdict.flagged else "reached_short"
    reached = say(f"rules.{key}", rule=rule_limited(rule, say), value=value, limit=limit)
    return ", ".join(filter(None, (reached, *_where(rule, say))))


def rule_limited(rule: Rule, say: Wording) -> str:
    """Return what a rule limits; with its circuit in the words of the workbook."""
    return say(f"rules.{rule.kind}") if rule.circuit is None else isolated(say.sentence(rule.quantity))


def _where(rule: Rule, say: Wording) -> tuple[str, str]:
    return "" if rule.condition is None else say.condition(rule.condition), say.sentence(rule.where)
