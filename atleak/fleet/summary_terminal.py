"""Show a summary of a fleet on a terminal."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from atleak.errors import Message
from atleak.fleet.summed import (
    Decider,
    Difference,
    ErrorKind,
    FleetSummary,
    Group,
    GroupComparison,
    SummedUnit,
    ValveBody,
    VerdictCounts,
    WearDifference,
)
from atleak.look import look_of
from atleak.report.terminal import TerminalConsole
from atleak.spreads import ENOUGH_UNITS, Rate, Spread
from atleak.verdicts import BANDS, VERDICTS, Verdict
from atleak.wording import signed

PAIRS, WORN, DECIDERS, DIFFERENCES, UNITS = 10, 3, 5, 12, 15  # rows of each table; the JSON and the workbook hold all
_OTHERS = "all others"
_POINTS = "[percentage points], interval of 95 % for all at once (* leaves out zero)"
_FEW = f"fewer than {ENOUGH_UNITS} units"


def print_summary(summary: FleetSummary) -> None:
    """Print verdicts, then each valve body with its worst lands, then errors and the worst units."""
    console = TerminalConsole()
    for part in (*_head(summary), *_bodies(summary), *_errors(summary.errors), *_units(summary)):
        console.print(Text(part) if isinstance(part, str) else part)


def _head(summary: FleetSummary) -> Iterator[str | Text | Table]:
    counts = summary.counts
    results = _counted(summary.visits, "result")
    yield f"{summary.folder}: {_counted(counts.units, 'unit')}, {results} of atleak {summary.atleak}"
    yield _verdicts("Units by verdict", ((body.controller, body.counts) for body in summary.bodies), counts)
    if counts.ok_in_part:
        ok = counts.verdicts[Verdict.OK]
        yield (
            f"Of {_counted(ok, 'unit')} with the verdict ok, {counts.ok_in_part} {_are(counts.ok_in_part)} so in part: "
            "not all lands were measured."
        )
    if counts.without_sheet:
        judged = f"{_counted(counts.without_sheet, 'unit')} without a measured land {_are(counts.without_sheet)}"
        yield f"{judged} judged by logs and gauges alone, and in no rate."
    if counts.provisional:
        verdicts = "verdict rests" if counts.provisional == 1 else "verdicts rest"
        yield f"Of {_counted(counts.provisional, 'unit')} the {verdicts} on representative values."
    if summary.groups:
        yield _verdicts(f"Units by {summary.by}", ((group.name, group.counts) for group in summary.groups), counts)
        if summary.not_stated:
            state = "states" if summary.not_stated == 1 else "state"
            are = _are(summary.not_stated)
            yield f"{_counted(summary.not_stated, 'unit')} {state} no {summary.by} and {are} in no group."
    elif summary.headings:
        yield f"Groups of units can be compared by {', '.join(summary.headings)}: --by {summary.headings[0]}"
    yield from _said(summary.messages)


def _counted(number: int, noun: str) -> str:
    """Return a number with what it counts.

    >>> _counted(1, "unit"), _counted(12, "unit")
    ('1 unit', '12 units')
    """
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def _are(number: int) -> str:
    return "is" if number == 1 else "are"


def _verdicts(title: str, rows: Iterable[tuple[str, VerdictCounts]], all_of_them: VerdictCounts) -> Table:
    levels = VERDICTS[::-1]
    levels_below = (signed(level).replace(" ", "\n", 1) for level in levels)
    table = _table(title, "", "units", *levels_below, "replace or\nworse %")
    for name, counts in (*rows, ("all", all_of_them)):
        cells = [Text(str(counts.verdicts[level]), style=_style(level, counts.verdicts[level])) for level in levels]
        _add(table, name, str(counts.units), *cells, _percent(counts.rates[Verdict.REPLACE]))
    return table


def _style(level: Verdict, count: int) -> str:
    return look_of(level).style if count else ""


def _said(messages: Iterable[Message]) -> Iterator[str]:
    for message in messages:
        yield f"! {message.text}" if message.level == "warning" else message.text


def _bodies(summary: FleetSummary) -> Iterator[str | Text | Table]:
    for body in summary.bodies:
        yield ""
        units, results = _counted(body.counts.units, "unit"), _counted(body.visits, "result")
        yield Text(f"{body.controller}: {units}, {results}", style="bold")
        yield from _said(body.messages)
        yield from _deciders(body.deciders)
        yield from _pairs(body)
        yield from _wear(body)
        yield from _temperatures(body)
        yield from _conditions(body)
        if body.comparison is not None:
            yield from _comparison(body.comparison)


def _deciders(deciders: Sequence[Decider]) -> Iterator[str]:
    others = [each for each in deciders if each.land is None]  # lands stand in the table of pairs
    if others:
        named = ", ".join(f"{_decided(each)} {_of(each.units)}" for each in others[:DECIDERS])
        yield f"What gave the verdicts of flagged units, besides lands: {named}"


def _decided(each: Decider) -> str:
    kind = each.kind.replace("_", " ")
    return kind if each.circuit is None else f"{kind} of {each.circuit}"


def _pairs(body: ValveBody) -> Iterator[str | Table]:
    worst = [each for each in body.pairs if each.flagged.count or each.deciding.count][:PAIRS]
    if not worst:
        measured = any(each.flagged.of for each in body.pairs)
        yield "No measured land has reached a limit." if measured else "No land of any unit was measured."
        return
    headings = "measured", "replace or\nworse %", "flagged %", "deciding %"
    table = _table("Lands that give the most trouble (95 % interval)", "land", *headings)
    for each in worst:
        rates = (_percent(rate) for rate in (each.replace, each.flagged, each.deciding))
        _add(table, _land(each.key), str(each.flagged.of), *rates)
    yield table


def _wear(body: ValveBody) -> Iterator[str | Table]:
    by_key = {each.key: each for each in body.wear}
    shown = [by_key[each.key] for each in body.pairs[:WORN] if by_key[each.key].classes]
    classes = sorted({(part.low_km, part.high_km) for land in shown for part in land.classes})
    if not classes:
        return
    names = [_land(land.key) for land in shown]
    table = _table("Wear over mileage [%]: median (5–95 % of the units), units", "1000 km", *names)
    for low, high in classes:
        cells = []
        for land in shown:
            here = next((part.wear_percent for part in land.classes if part.low_km == low), None)
            cells.append("–" if here is None else f"{_spread(here, 0)}, {here.units}")
        _add(table, f"{low / 1e3:g}–{high / 1e3:g}", *cells)
    yield table
    without = max(land.without_mileage for land in body.wear)
    if without:
        yield f"Up to {without} measurements of a land have no mileage and are in no class."
    repaired = sum(land.repaired for land in body.wear)
    if repaired:
        yield f"{repaired} measurements of lands that were repaired are left out of the wear."


def _temperatures(body: ValveBody) -> Iterator[Table]:
    if not body.temperatures:
        return
    table = _table(
        "Over the fluid temperature of the logs: mean of all time (5–95 % of the units)",
        *("°C", "units", "hours", "share %", "largest", "main\npressure kPa", "lowest", "red or\nworse %"),
    )
    for each in body.temperatures:
        bands = each.bands_percent
        worse = None if bands is None else sum(bands[band] for band in BANDS[2:])
        units = max((part.units for part in (each.share_percent, each.pressure_kpa) if part), default=0)
        _add(
            table,
            f"{each.low_c:g}–{each.high_c:g}",
            *(str(units), f"{each.seconds / 3600.0:.1f}"),
            *(_mean(each.share_mean_percent, each.share_percent, 1), _number(each.share_max_percent, 1)),
            *(_mean(each.pressure_mean_kpa, each.pressure_kpa, 0), _number(each.pressure_min_kpa, 0)),
            _number(worse, 1),
        )
    yield table


def _conditions(body: ValveBody) -> Iterator[Table]:
    if not body.conditions:
        return
    table = _table(
        "At the stated conditions: median (5–95 % of the units)",
        *("condition", "°C", "units", "in\npart", "share %", "pressure\nheld kPa", "required", "red or\nworse"),
    )
    for each in body.conditions:
        units = max((part.units for part in (each.share_percent, each.pressure_held_kpa) if part), default=0)
        _add(
            table,
            *(each.label, f"{each.temperature_c:g}", str(units), str(each.partly)),
            *(_spread(each.share_percent, 1), _spread(each.pressure_held_kpa, 0), _number(each.required_kpa, 0)),
            str(sum(each.bands[band] for band in BANDS[2:])),
        )
    yield table


def _comparison(comparison: GroupComparison) -> Iterator[str | Table]:
    table = _table("Groups", "", "units", "replace or\nworse %", "mean km", "without\nkm")
    for group in comparison.groups:
        _add(table, *_group(group))
    yield table
    yield from _said(comparison.messages)
    rates = [each for each in comparison.verdicts if each.points is not None]
    if rates:
        table = _table(f"Differences of rates {_POINTS}", "groups", "rate of", "difference", words=2)
        for rate in rates:
            _add(table, _compared(rate.first, rate.second), _or_worse(rate.verdict), _points(rate.points))
        yield table
    yield from _wear_differences(comparison)


def _or_worse(verdict: Verdict) -> str:
    return str(verdict) if verdict is VERDICTS[-1] else f"{verdict} or worse"


def _group(group: Group) -> tuple[str, ...]:
    return (
        *(group.name, str(group.counts.units), _percent(group.counts.rates[Verdict.REPLACE])),
        *(_number(group.mileage_km.mean if group.mileage_km else None, 0), str(group.without_mileage)),
    )


def _wear_differences(comparison: GroupComparison) -> Iterator[str | Table]:
    called = [each for each in comparison.lands if _is_called(each)]
    if not called:
        compared = any(each.mean_points and each.mean_points.differs is not None for each in comparison.lands)
        yield (
            "For no land does the wear tell the groups apart."
            if compared
            else f"No wear is compared: {_FEW} in a group."
        )
        return
    headings = "groups", "land", "difference", "at the same mileage"
    table = _table(f"Differences of mean wear {_POINTS}", *headings, words=2)
    for each in called[:DIFFERENCES]:
        points = (_points(of_kind) for of_kind in (each.mean_points, each.same_mileage_points))
        _add(table, _compared(each.first, each.second), _land(each.key), *points)
    yield table
    if len(called) > DIFFERENCES:
        yield f"… and {len(called) - DIFFERENCES} more that differ."


def _is_called(each: WearDifference) -> bool:
    return any(points is not None and points.differs for points in (each.mean_points, each.same_mileage_points))


def _errors(errors: Sequence[ErrorKind]) -> Iterator[str]:
    for each in errors:
        yield ""
        yield f"{each.count} without a result ({each.kind}):"
        for told in each.told:
            yield f"  {told}"


def _units(summary: FleetSummary) -> Iterator[str | Table]:
    if not summary.worst:
        return
    headings = "unit", "valve body", "verdict", "decided by", "lands to\nreplace", "km"
    table = _table("Units, the worst first", *headings, words=4)
    for each in summary.worst[:UNITS]:
        _add(
            table,
            *(each.name, each.controller, Text(signed(each.verdict), style=look_of(each.verdict).style)),
            *(_gave(each), str(each.lands_past), _number(each.mileage_km, 0)),
        )
    yield ""
    yield table


def _gave(unit: SummedUnit) -> str:
    decided_by = unit.decided_by
    if isinstance(decided_by, tuple):
        return _land(decided_by)
    return "–" if decided_by is None else decided_by.replace("_", " ")


# --- cells


def _table(title: str, *headings: str, words: int = 1) -> Table:
    """Return a table without rows, whose first columns are words and the others numbers."""
    table = Table(title=Text(title), title_justify="left", box=SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
    for number, heading in enumerate(headings):
        if number < words:
            table.add_column(Text(heading), overflow="fold")
        else:
            table.add_column(Text(heading), justify="right", no_wrap=True)
    return table


def _add(table: Table, *cells: str | Text) -> None:
    table.add_row(*(Text(cell) if isinstance(cell, str) else cell for cell in cells))


def _land(key: tuple[str, int]) -> str:
    return "/".join(map(str, key))


def _compared(first: str, second: str | None) -> str:
    return f"{first} − {second or _OTHERS}"


def _number(value: float | None, digits: int) -> str:
    return "–" if value is None else f"{value:.{digits}f}"


def _of(rate: Rate) -> str:
    return f"{rate.count} of {rate.of}"


def _percent(rate: Rate) -> str:
    """Return a rate with its interval; of few units the count alone."""
    if rate.low_percent is None or rate.percent is None:
        return _of(rate)
    return f"{rate.percent:.1f} ({_short(rate.low_percent)}–{_short(rate.high_percent)})"


def _spread(spread: Spread | None, digits: int) -> str:
    return "–" if spread is None else f"{spread.median:.{digits}f}{_ends(spread)}"


def _mean(mean: float | None, spread: Spread | None, digits: int) -> str:
    return "–" if mean is None or spread is None else f"{mean:.{digits}f}{_ends(spread)}"


def _ends(spread: Spread) -> str:
    """Return the outer quantiles; of few units nothing."""
    return "" if spread.quantiles is None else f" ({_short(spread.quantiles[0])}–{_short(spread.quantiles[-1])})"


def _short(value: float | None) -> str:
    """Return a number as short as two digits can say it."""
    return "–" if value is None else f"{value:.0f}" if abs(value) >= 9.95 else f"{value:.1f}"


def _points(points: Difference | None) -> str:
    if points is None:
        return "–"
    if points.low_of_all is None:
        return f"{points.value:+.1f} ({_FEW})"
    called = " *" if points.differs else ""
    return f"{points.value:+.1f} ({points.low_of_all:+.1f} … {points.high_of_all:+.1f}){called}"
