"""Tables of a road-test log: its events and pressures, its channels over a part, the instants that are read first.

For a sheet or a page its leakage is thinned: few samples, no spike lost, gaps kept. Each channel is shown in the unit
in which its reader sees it, and so is what a formula gives.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from atleak.analysis.formulas import Dimension, FormulaChannel
from atleak.catalogue.controller import Controller
from atleak.catalogue.limits import Limits
from atleak.catalogue.workbook.cells import gear_shown
from atleak.common.sentences import Sentence
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM, Unit, gear_name
from atleak.common.units import unit as named_unit
from atleak.common.wording import Wording
from atleak.diagnosis.road import RoadFindings
from atleak.diagnosis.uncertainty import UnitUncertainty
from atleak.engine.extremes import Extremes, Instant
from atleak.engine.road_leakage import RoadLeakage
from atleak.engine.road_pressure import Departure, PlaceFinding, RoadPressure, permitted_pressure
from atleak.measurements.events import Event
from atleak.measurements.road_test import Channel, RoadTest, thinned
from atleak.readers.logs.understood import workshop_unit
from atleak.report.json.conditions import interval_ends, named_record
from atleak.report.tables.road_words import event_remark
from atleak.report.tables.table import Column, Facts, Table

Scale = tuple[str, Callable[[Any], Any]]  # a unit's name, and the function from SI to it
Scales = Mapping[str, Scale]  # by quantity
_SHOWN = {  # kind of quantity → the reader's kind, and the unit that atleak's records have it in
    "pressure": ("pressure", named_unit("kPa", "pressure")),
    "rotational_speed": ("engine_speed", named_unit("rpm", "rotational_speed")),
    "speed": ("speed", named_unit("km/h", "speed")),
    "temperature": ("temperature", named_unit("°C", "temperature")),
    "temperature_difference": ("temperature_difference", Unit("°C", 1.0)),
    "time": ("time", named_unit("s", "time")),
}
_POWERS = {2: "²", 3: "³"}
# of the log itself, of the one laid over it, the least and the most that is permitted, where a band begins
Look = Literal["own", "over", "least", "most", "edge"]
_LIMITS: tuple[Look, Look] = ("least", "most")
_OF_SHARE = ("max_share_sustained", "max_share")  # the instants that are marked in the curve of the share
_STEPS = frozenset({"gear", "selector", "lock_up"})


@dataclass(frozen=True, eq=False)
class LaidOver:
    """A second log: its road test, by how much it is shifted [s], and its formulas by name."""

    test: RoadTest
    shift: float
    formulas: Mapping[str, FormulaChannel] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve over a log, in the reader's unit: arrays of shape (samples,), values NaN where they do not count."""

    name: str
    unit: str
    time: np.ndarray  # [s]
    values: np.ndarray
    look: Look = "own"
    steps: bool = False  # a value holds until the next
    suspect: tuple[np.ndarray, np.ndarray] | None = None  # stamps and values of samples that no result uses
    beside: tuple[Curve, ...] = ()  # others on the same axes
    marks: tuple[tuple[float, float, str, str], ...] = ()  # stamp, value, words and symbol of instants to see
    from_zero: bool = False


def event_table(events: Sequence[Event], say: Wording) -> Table:
    """Return a row for every event of a log."""
    columns = (
        Column("event", of=lambda event: say(f"events.{event.kind}"), width=150),
        Column("event_gears", of="gears"),
        Column("event_start", "time", 2, of="start"),
        Column("event_stop", "time", 2, of="stop"),
        Column("event_lasts", "time", 2, of="duration"),
        Column("event_source", of=lambda event: say.get("event_sources", event.source)),
        Column("event_note", of=lambda event: event_remark(event, say) or None, width=300),
    )
    return Table("events", columns, events, say)


def place_table(permitted: RoadPressure, say: Wording) -> Table:
    """Return a row for every gear and state in which main pressure was judged."""

    def worst(place: PlaceFinding, of: Callable[[Departure], Any]) -> Any:
        return None if place.worst is None else of(place.worst)

    columns = (
        Column("place_gear", of=lambda place: gear_shown(place.gear)),
        Column("place_state", of=lambda place: say(f"states.{place.state}"), width=100),
        Column("place_judged", "time", 2, of="judged"),
        Column("place_lowest", "pressure", 0, of=lambda place: worst(place, lambda at: at.pressure), times=KPA),
        Column("place_limit", "pressure", 0, of=lambda place: worst(place, lambda at: at.limit), times=KPA),
        Column(
            "place_below_by", "percent", 1, of=lambda place: worst(place, lambda at: max(at.fraction, 0)), times=PERCENT
        ),
        Column("place_below", "time", 2, of="below"),
        Column("place_above", "time", 2, of="above"),
        Column("place_source", of=lambda place: worst(place, lambda at: say.name(at.source))),
    )
    return Table("places", columns, permitted.places, say)


def circuit_table(road: RoadLeakage, say: Wording) -> Table:
    """Return a row for every circuit that the log applies: what it holds."""
    columns = (
        Column("circuit", of=lambda each: each.circuit.name),
        Column("circuit_lowest", "pressure", 0, of="lowest", times=KPA),
        Column("circuit_at_main", "pressure", 0, of="main_pressure", times=KPA),
        Column("circuit_at", "time", 1, of="time"),
        Column("circuit_mean", "pressure", 0, of="mean", times=KPA),
    )
    return Table("circuits", columns, [*road.circuit_ranges.values()], say)


def present_values(log: RoadFindings, controller: Controller, say: Wording) -> Facts:
    """Return what a log shows at its last sample, main pressure first, and beside it what is permitted there."""
    test, scales = log.road_test, channel_scales(log.road_test, say)
    limits = permitted_pressure(controller, test)
    rows = [(say("log_quantities.time"), f"{say.number(test.time[-1], 1)} s")]
    for name in (each for each in test.channels if each in scales or each == "gear"):
        unit, convert = scales.get(name, ("", as_it_is))
        last = float(np.asarray(test.values(name))[-1])
        if math.isnan(last):
            shown = "–"
        else:
            shown = gear_name(int(last)) if name == "gear" else f"{short(float(convert(last)), say)} {unit}"
        if name == "main_pressure" and limits is not None:
            shown += _beside_limits(last, (limits[0][-1], limits[1][-1]), convert, say)
        rows.insert(1 if name == "main_pressure" else len(rows), (say(f"log_quantities.{name}"), shown))
    return Facts(rows)


def _beside_limits(pressure: float, limits: tuple[float, float], convert: Callable[[Any], Any], say: Wording) -> str:
    """Say what main pressure is permitted where it is now, and on which side of it it lies; nothing without a limit."""
    ends = dict(zip(_LIMITS, limits, strict=True))
    known = {name: short(float(convert(end)), say) for name, end in ends.items() if not math.isnan(end)}
    if not known:
        return ""
    name = "_".join(known)
    side = "below" if pressure < ends["least"] else "above" if pressure > ends["most"] else ""
    outside = f" ▲ {say(f'live.{side}')}" if side else ""
    return f" ({say(f'live.{name}', **known)}){outside}"


def log_curves(
    test: RoadTest,
    say: Wording,
    *,
    formulas: Sequence[FormulaChannel] = (),
    over: LaidOver | None = None,
    permitted: tuple[np.ndarray, np.ndarray] | None = None,
    road: RoadLeakage | None = None,
    limits: Limits | None = None,
) -> list[Curve]:
    """Return every channel of a log, its formulas, and its leakage, pump flow and share.

    Parameters
    ----------
    formulas
        channels that were computed from this log's.
    over
        a second log, whose channels and formulas stand beside this log's.
    permitted
        least and largest main pressure [Pa] at each sample, NaN where there is no limit.
    road
        the leakage over this log; of its share the bands of ``limits`` are drawn that begin near it.
    """
    scales, curves = channel_scales(test, say), []
    for name, channel in test.channels.items():
        if not channel.samples:
            continue
        scale = scales.get(name, (channel.unit, as_it_is))
        curve = _channel_curve(test, channel, scale, say)
        other = None if over is None else over.test.channel(name)
        beside = [_over(over, _channel_curve(over.test, other, scale, say))] if over and other and other.samples else []
        if name == "main_pressure" and permitted is not None:
            beside += [
                Curve(say(f"road_test.permitted_{look}"), curve.unit, test.time, scale[1](limit), look, steps=True)
                for look, limit in zip(_LIMITS, permitted, strict=True)
                if np.isfinite(limit).any()
            ]
        curves.append(replace(curve, beside=tuple(beside)))
    for each in formulas:
        laid = None if over is None else over.formulas.get(each.name)
        beside = [_over(over, _formula_curve(laid, say))] if over and laid and laid.dimension == each.dimension else []
        curves.append(replace(_formula_curve(each, say), beside=tuple(beside)))
    return curves if road is None else [*curves, *leakage_curves(road, limits, say)]


def _channel_curve(test: RoadTest, channel: Channel, scale: Scale, say: Wording) -> Curve:
    unit, convert = scale
    time, good, suspect = channel.time, channel.good, None
    if channel.source == "constant":
        time = test.time[:: max(len(test.time) - 1, 1)]  # both ends, as far as there are samples
        good = np.full(len(time), channel.values[0])
    elif (doubted := channel.suspect & np.isfinite(channel.values)).any():
        suspect = time[doubted], convert(channel.values[doubted])
    name, steps = say(f"log_quantities.{channel.quantity}"), channel.quantity in _STEPS
    return Curve(name, unit, time, convert(good), steps=steps, suspect=suspect)


def _formula_curve(computed: FormulaChannel, say: Wording) -> Curve:
    unit, convert = formula_scale(computed.dimension, say)
    return Curve(computed.name, unit, computed.time, convert(computed.values))


def _over(over: LaidOver, curve: Curve) -> Curve:
    name = f"{curve.name}, {over.test.file}"
    return replace(curve, name=name, time=curve.time + over.shift, look="over", suspect=None)


def leakage_curves(road: RoadLeakage, limits: Limits | None, say: Wording) -> list[Curve]:
    """Return the leakage over a log with its extremes; with a logged engine speed also the pump's flow and the share.

    A band of the limits is drawn where it begins near the log's share: a high limit must not squeeze a low curve.
    """
    leakage, shares = [], []
    for row in road_instants(road):
        words = f"{row.label(say)}, {say.number(row.instant.time, 2)} s"
        symbol = "diamond" if row.leads else "diamond-open"
        if row.name not in _OF_SHARE:
            flow = say.convert(row.instant.leakage * DM3_MIN, "flow")
            leakage.append((row.instant.time, flow, words, symbol))
        elif row.instant.share is not None:
            shares.append((row.instant.time, row.instant.share * PERCENT, words, symbol))

    def curve(name: str, kind: str, values: np.ndarray, marks: list[Any], beside: tuple[Curve, ...] = ()) -> Curve:
        named, shown = say(f"road_test.{name}"), say.convert(values, kind)
        return Curve(named, say.unit(kind), road.time, shown, beside=beside, marks=tuple(marks), from_zero=True)

    curves = [curve("leakage_row", "flow", road.leakage * DM3_MIN, leakage)]
    if road.pump_capacity is None or road.share is None:
        return curves
    bands = () if limits is None else [(band, level * PERCENT) for band, level in limits.fixed_bands]
    top = 1.5 * PERCENT * float(np.nanmax(road.share, initial=0.0))
    edges = tuple(
        Curve(
            say("road_test.band_from", band=say.level(band), edge=say.plain(edge)), "%", road.time[[0, -1]],
            np.full(2, edge), "edge",
        )
        for number, (band, edge) in enumerate(bands)
        if not number or edge <= top
    )  # fmt: skip
    pump = curve("pump_flow", "flow", road.pump_capacity * DM3_MIN, [])
    return [*curves, pump, curve("share", "percent", road.share * PERCENT, shares, edges)]


def value_rows(curves: Sequence[Curve], say: Wording) -> list[dict[str, str]]:
    """Return one row for every curve that has a value, limits apart: its least, mean and largest.

    Notes
    -----
    The mean is that of a channel's own samples, each counting alike.
    """
    rows = []
    for curve in (each for own in curves for each in (own, *own.beside) if each.look in ("own", "over")):
        good = curve.values[np.isfinite(curve.values)]
        if len(good):
            ends = {"log_least": good.min(), "log_mean": good.mean(), "log_largest": good.max()}
            written = {name: short(float(value), say) for name, value in ends.items()}
            rows.append({"log_channel": curve.name, "log_in": curve.unit, **written})
    return rows


def short(value: float | None, say: Wording) -> str:
    """Return a number with three digits and every digit before the decimal sign: ``1.65``, ``92.7``, ``2 346``."""
    if value is None or not math.isfinite(value):
        return say.number(None, 0)
    if value.is_integer():
        return say.number(value, 0)
    digits = 3 if abs(value) < 0.001 else min(max(2 - math.floor(math.log10(abs(value))), 0), 5)
    return say.number(value, digits)


def whole(count: int | None, say: Wording) -> str:
    """Return a count with its thousands parted: ``1 800 000``."""
    return say.number(None if count is None else float(count), 0)


def as_it_is(values: Any) -> Any:
    """Return values in the unit that they are in."""
    return values


@dataclass(frozen=True)
class RoadInstant:
    """One instant as it is shown: ``name`` is its key in records and texts."""

    name: str
    instant: Instant
    leads: bool  # read first, and marked in a printed picture: sustained, or without a sustained counterpart
    after_start: bool = False  # in the first moments after a start of the engine

    def label(self, say: Wording) -> str:
        """Return its name in the reader's language."""
        label = say(f"instants.{self.name}")
        return say("instants.after_start", instant=label) if self.after_start else label


def road_instants(road: RoadLeakage) -> tuple[RoadInstant, ...]:
    """Return the instants of a road test in the order in which people read them."""
    rows = [*_of(road.extremes), RoadInstant("min_leakage", road.min_leakage, True)]
    if road.start is not None:
        rows += [RoadInstant(row.name, row.instant, True, True) for row in _of(road.start) if row.leads]
    return tuple(rows)


def _of(extremes: Extremes) -> Iterable[RoadInstant]:
    """Return the largest leakage and share, sustained where that is known, then as single samples."""
    pairs = (
        ("max_leakage", extremes.max_leakage, extremes.max_leakage_sustained),
        ("max_share", extremes.max_share, extremes.max_share_sustained),
    )
    yield from (RoadInstant(f"{name}_sustained", sustained, True) for name, _, sustained in pairs if sustained)
    yield from (RoadInstant(name, single, sustained is None) for name, single, sustained in pairs if single)


def instant_record(instant: Instant, uncertainty: UnitUncertainty | None) -> dict[str, Any]:
    """Return an instant with its 95 % intervals in workshop units, as records hold it; None where a value is not known.

    Without readings nothing was measured and no interval is known.
    """
    interval = uncertainty.instants.get(instant) if uncertainty else None
    return {
        **named_record(instant, "time_s", "leakage_dm3_min"),
        **interval_ends("leakage_{}_dm3_min", interval.leakage_interval if interval else None, DM3_MIN),
        **named_record(instant, "pump_capacity_dm3_min", "share_percent"),
        **interval_ends("share_{}_percent", interval.share_interval if interval else None, PERCENT),
    }


def instant_table(road: RoadLeakage, uncertainty: UnitUncertainty | None, say: Wording) -> Table:
    """Return a row for every instant; columns without any value are left out."""
    columns = (
        Column("instant", width=190),
        Column("instant_time", "time", 2, of="time_s"),
        Column("instant_leakage", "flow", 2, of="leakage_dm3_min"),
        Column("instant_leakage_low", "flow", 2, of="leakage_low_dm3_min"),
        Column("instant_leakage_high", "flow", 2, of="leakage_high_dm3_min"),
        Column("instant_pump", "flow", 1, of="pump_capacity_dm3_min"),
        Column("instant_share", "percent", 2, of="share_percent"),
        Column("instant_share_low", "percent", 1, of="share_low_percent"),
        Column("instant_share_high", "percent", 1, of="share_high_percent"),
    )
    rows = [{"instant": row.label(say), **instant_record(row.instant, uncertainty)} for row in road_instants(road)]
    return Table("instants", columns, rows, say).filled


@dataclass(frozen=True)
class RoadSeries:
    """Columns of equal length by name, in workshop units; NaN where a sample is not usable."""

    columns: dict[str, np.ndarray]
    labels: dict[str, tuple[Sentence, str]]  # the same names → words and kind of quantity
    samples: int  # of the log
    instants: tuple[RoadInstant, ...]

    @property
    def thinned(self) -> bool:
        return self.samples > len(self.columns["time_s"])


def road_series(road: RoadLeakage, points: int) -> RoadSeries:
    """Return about ``points`` samples of a road test.

    They are `thinned` by leakage and share; the instants that the result names are among them.
    """
    series, instants = [road.leakage] if road.share is None else [road.leakage, road.share], road_instants(road)
    keep = thinned(series, points, keep=[row.instant.sample for row in instants])
    named = _columns(road)
    return RoadSeries(
        columns={name: array[keep] * factor for name, _, _, array, factor in named},
        labels={name: (label, kind) for name, label, kind, _, _ in named},
        samples=len(road.time),
        instants=instants,
    )


def _columns(road: RoadLeakage) -> list[tuple[str, Sentence, str, np.ndarray, float]]:
    """Return name, words, kind of quantity, values in SI and the factor from SI to the unit of atleak's records."""
    columns = [
        ("time_s", Sentence("time"), "time", road.time, 1.0),
        ("leakage_dm3_min", Sentence("leakage"), "flow", road.leakage, DM3_MIN),
    ]
    share = road.share
    if road.pump_capacity is not None and share is not None:
        columns.append(("pump_capacity_dm3_min", Sentence("pump capacity"), "flow", road.pump_capacity, DM3_MIN))
        columns.append(("share_percent", Sentence("share"), "percent", share, PERCENT))
    for section, flow in road.sections.items():
        said = Sentence("leakage {section}", section=section)
        columns.append((f"leakage_{section}_dm3_min", said, "flow", flow, DM3_MIN))
    for circuit, pressure in road.circuits.items():
        columns.append((f"{circuit}_kpa", Sentence("{circuit}, computed", circuit=circuit), "pressure", pressure, KPA))
    for quantity, name, said, kind, factor in (
        ("main_pressure", "p_g_kpa", Sentence("p_g"), "pressure", KPA),
        ("converter_pressure", "p_k_kpa", Sentence("p_k"), "pressure", KPA),
        ("engine_speed", "engine_rpm", Sentence("engine"), "engine_speed", RPM),
        ("atf_temperature", "temperature_c", Sentence("temperature"), "temperature", 1.0),
        ("gear", "gear", Sentence("gear"), "", 1.0),
    ):
        values = road.road_test.values(quantity)
        if values is not None:
            columns.append((name, said, kind, values, factor))
    return columns


def channel_scales(test: RoadTest, say: Wording) -> dict[str, Scale]:
    """Return, by quantity, the unit that the reader has it in and the function from SI to it."""
    scales: dict[str, Scale] = {}
    for name, channel in test.channels.items():
        shown = workshop_unit(name, channel)
        kind = next((kind for kind, (_, record) in _SHOWN.items() if record == shown), None)
        if kind is not None:
            scales[name] = _scale(kind, say)
        elif shown is not None:
            scales[name] = (shown.name, shown.from_si)
    return scales


def formula_scale(dimension: Dimension, say: Wording) -> Scale:
    """Return the unit that the reader has a formula's values in, such as ``kPa/s``, and the function from SI to it."""
    if not dimension:
        return "", lambda value: value
    if len(dimension) == 1 and dimension[0][1] == 1:
        return _scale(dimension[0][0], say)
    factor = 1.0
    above: list[str] = []
    below: list[str] = []
    for kind, power in dimension:
        name, convert = _scale(kind, say)
        factor *= (convert(1.0) - convert(0.0)) ** power
        (above if power > 0 else below).append(name + _POWERS.get(abs(power), "" if abs(power) == 1 else f"^{power}"))
    name = "/".join(["·".join(above) or "1", *below])
    return name, lambda value: value * factor


def _scale(kind: str, say: Wording) -> Scale:
    shown, record = _SHOWN[kind]
    return say.unit(shown), lambda value: say.convert(record.from_si(value), shown)
