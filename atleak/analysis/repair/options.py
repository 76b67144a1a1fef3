"""List how lands can be mended by what the controller's file names, what that leaves of each, and what it costs.

Amounts are rounded as people write them: to the currency's smallest unit, half of it upwards.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from decimal import ROUND_HALF_UP, Decimal

from atleak.analysis.repair.totals import LandChoice
from atleak.catalogue.repairs import LandKey, Repair
from atleak.common.verdicts import Verdict, worst
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.land import LandDiagnosis
from atleak.diagnosis.rules import land_rules
from atleak.engine.projection import project, repaired, with_even_clearance
from atleak.measurements.clearances import LandClearance

# ISO 4217:2015, list one: minor units where they are not two.
_NONE = ("BIF", "CLP", "DJF", "GNF", "ISK", "JPY", "KMF", "KRW", "PYG", "RWF", "UGX", "VND", "VUV", "XAF", "XOF", "XPF")
_THREE = ("BHD", "IQD", "JOD", "KWD", "LYD", "OMR", "TND")
MoveKey = str | LandKey  # the id of a repair of the file, or the land that is made as new without one


@dataclass(frozen=True)
class Cost:
    """What repairs cost together: parts by currency, and hours of work."""

    prices: Mapping[str, float]  # by currency, in the order in which they come
    hours: float  # [h] of work
    repairs: int  # that are counted
    without_price: int  # repairs among them whose file states none
    without_hours: int  # repairs of which nobody states the hours
    without_option: int  # lands, and the pump, made as new, for which the file names nothing that mends them


@dataclass(frozen=True)
class Option:
    """One repair of the controller's file, and how it leaves the lands that it changes."""

    repair: Repair  # as the file states it
    states: Mapping[LandKey, LandClearance]  # of every land that it changes, afterwards; none of one of the pump
    mending: frozenset[LandKey]  # the lands that are then within their limits, and tighter than measured

    @property
    def lands(self) -> tuple[LandKey, ...]:
        """Return every land that it changes."""
        return tuple(self.states)

    def mends(self, key: LandKey) -> bool:
        """Tell whether a land is tighter afterwards, and within its limits."""
        return key in self.mending


class Options:
    """The repairs that a controller's file names, seen from one unit.

    A pump past its limits is taken as new: it is repaired first, and what is then left is up to the lands.
    """

    def __init__(self, diagnosis: Diagnosis) -> None:
        unit = diagnosis.valve_body
        self.of_workshop = diagnosis.repairs
        by_key = {land.key: land for land in unit.lands}
        self.all = tuple(_option(repair, by_key, unit) for repair in diagnosis.controller.repairs)

    @property
    def of_pump(self) -> tuple[Option, ...]:
        """Return the options for the pump, in the order of the file."""
        return tuple(option for option in self.all if option.repair.of_pump)

    def of(self, key: LandKey) -> tuple[Option, ...]:
        """Return the options for one land, in the order of the file."""
        return tuple(option for option in self.all if key in option.states)

    def wanted(self, key: LandKey) -> Option | None:
        """Return the option that the workshop chose for a land, whether it mends the land or not; None without one."""
        return next((option for option in self.of(key) if option.repair in self.of_workshop), None)


def cost_of(options: Iterable[Option | None]) -> Cost:
    """Add up what repairs cost; None stands for a land, or the pump, that is made as new without one."""
    listed = list(options)
    repairs = [option.repair for option in listed if option is not None]
    prices: dict[str, float] = defaultdict(float)
    for repair in repairs:
        if repair.price is not None and repair.currency is not None:
            prices[repair.currency] += repair.price
    return Cost(
        prices=dict(prices),
        hours=sum(repair.hours or 0.0 for repair in repairs),
        repairs=len(repairs),
        without_price=sum(repair.price is None for repair in repairs),
        without_hours=sum(repair.hours is None for repair in repairs),
        without_option=len(listed) - len(repairs),
    )


def _option(repair: Repair, lands: Mapping[LandKey, LandDiagnosis], diagnosis: Diagnosis) -> Option:
    mine = [land for land in lands.values() if repair.changes(land.key)]
    states = {land.key: _after(repair, land.state) for land in mine}
    tighter = [land for land in mine if states[land.key].radial_clearance < land.state.radial_clearance]
    mending = frozenset(land.key for land in tighter)
    if repair.ends and tighter:  # new parts are as new
        mending &= _within_limits([_widest(land.state, states[land.key]) for land in mine], diagnosis)
    return Option(repair, states, mending)


def _after(repair: Repair, state: LandClearance) -> LandClearance:
    """Return a land after a repair; one that is only cleaned keeps the clearance that was measured."""
    if repair.keeps_clearance:
        return state
    land = state.land.with_repair(repair)
    if repair.nominal_diameter is not None:
        state = replace(state, spool_diameter=repair.nominal_diameter)
    (after,) = repaired([replace(state, land=land)], [land.key])
    return after


def _widest(before: LandClearance, after: LandClearance) -> LandClearance:
    """Return a land as wide as its repair may leave it, still worn from what it had when new."""
    return replace(with_even_clearance(after, after.land.widest_new), land=before.land)


def _within_limits(states: Iterable[LandClearance], diagnosis: Diagnosis) -> frozenset[LandKey]:
    """Return which lands are within all of their limits, in a unit that is otherwise as it was measured.

    Where the pump delivers nothing no clearance has a share that is within a limit, and none is judged by it.
    """
    by_key = {state.land.key: state for state in states}
    clearances = tuple(by_key.get(each.land.key, each) for each in diagnosis.model.clearances)
    model = replace(diagnosis.model, clearances=clearances)
    delivering = (now for now in diagnosis.projections if now.pump_capacity > 0.0)
    at = [(project(model, now.condition), diagnosis.unworn_at(now)) for now in delivering]
    rules = {key: land_rules(state, at, diagnosis.limits) for key, state in by_key.items()}
    return frozenset(key for key, judged in rules.items() if worst(rule.verdict for rule in judged) is Verdict.OK)


def decimals(currency: str) -> int:
    """Return how many decimals an amount of a currency has; two where nothing else is known.

    >>> decimals("EUR"), decimals("jpy"), decimals("KWD"), decimals("")
    (2, 0, 3, 2)
    """
    code = currency.strip().upper()
    return 0 if code in _NONE else 3 if code in _THREE else 2


def amount(value: float | Decimal, currency: str) -> Decimal:
    """Return an amount in the smallest units of its currency, half a unit rounded up, away from zero.

    A number counts as the decimal number that it is written as: 1.005 is one and five thousandths.

    >>> amount(1.005, "EUR"), amount(2.675, "PLN"), amount(0.5, "JPY"), amount(12.0, "EUR")
    (Decimal('1.01'), Decimal('2.68'), Decimal('1'), Decimal('12.00'))
    """
    exact = value if isinstance(value, Decimal) else Decimal(repr(float(value)))
    return exact.quantize(Decimal(1).scaleb(-decimals(currency)), ROUND_HALF_UP)


def product(first: float, second: float, currency: str) -> Decimal:
    """Return hours × rate, or the like, as an amount; the factors count as the decimal numbers they are written as.

    >>> product(1.15, 3.5, "EUR")
    Decimal('4.03')
    """
    return amount(Decimal(repr(float(first))) * Decimal(repr(float(second))), currency)


@dataclass(frozen=True)
class Move:
    """One repair that can be chosen: an option of the valve body's file, or a land made as new without one."""

    option: Option | None  # None: made as new without one
    lands: tuple[LandKey, ...]  # whose clearance it changes
    treats: frozenset[LandKey]  # of which it counts as the repair

    @property
    def key(self) -> MoveKey:
        """Return what names it."""
        return self.lands[0] if self.option is None else self.option.repair.id

    def goes_with(self, other: Move) -> bool:
        """Tell whether both can be done: of two options no land has both, and none that one mends is made as new."""
        if self.option is not None and other.option is not None:
            return self.option.states.keys().isdisjoint(other.option.states)
        return not any(one.option and one.option.mends(two.lands[0]) for one, two in ((self, other), (other, self)))


@dataclass(frozen=True)
class StatedPrice:
    """What the workshop typed of one repair; None where it typed nothing."""

    price: float | None = None
    hours: float | None = None


@dataclass(frozen=True)
class Prices:
    """What repairs cost: part and hours × labour rate, as the file states them or as the workshop typed them."""

    labour_rate: float | None = None  # per hour; None: hours are not counted
    currency: str = ""  # of the labour rate and of what was typed; none where nobody said
    typed: Mapping[MoveKey, StatedPrice] = field(default_factory=dict)

    def price(self, move: Move) -> float | None:
        """Return the price of the part; None where it is unknown, or in another currency than that of the estimate."""
        typed = self.typed.get(move.key, StatedPrice()).price
        if typed is not None or move.option is None:
            return typed
        other = self.currency and move.option.repair.currency != self.currency
        return None if other else move.option.repair.price

    def hours(self, move: Move) -> float | None:
        """Return the hours of work; None where they are unknown."""
        typed = self.typed.get(move.key, StatedPrice()).hours
        return typed if typed is not None or move.option is None else move.option.repair.hours

    def currency_of(self, move: Move) -> str:
        """Return the currency in which the price of a repair is."""
        return self.currency or (move.option.repair.currency if move.option is not None else None) or ""

    def cost(self, move: Move) -> Decimal | None:
        """Return part and work together, each rounded as in an estimate; None where either is unknown."""
        price, hours, currency = self.price(move), self.hours(move), self.currency_of(move)
        if price is None or (self.labour_rate is not None and hours is None):
            return None
        work = Decimal(0) if self.labour_rate is None else product(hours or 0.0, self.labour_rate, currency)
        return amount(price, currency) + work


class Moves:
    """The repairs that are offered for some lands of a unit, in the order of lands and of the file.

    A land for which the workshop chose a repair has that one alone. Any other has every option of the file that leaves
    it within its limits, or is made as new where there is none. An option without a price is not offered
    where others, with a price, do what it does for flagged lands.

    Parameters
    ----------
    kept
        ids of repairs that are taken for their lands, whatever else the file names; of two that change one land the
        first.
    as_new
        whether every land can be made as new, options or not.
    """

    def __init__(
        self,
        options: Options,
        lands: Iterable[LandDiagnosis],
        prices: Prices,
        *,
        kept: Iterable[str] = (),
        as_new: bool = False,
    ) -> None:
        lands = list(lands)
        self.options, self.prices = options, prices
        self.wanted = dict(self._wanted(kept))
        self._flagged = {land.key for land in lands if land.verdict.flagged}
        offered = {land.key: self._offered(land, as_new=as_new) for land in lands}
        self.of_land: dict[LandKey, tuple[Move, ...]] = {}
        treats: dict[str, set[LandKey]] = defaultdict(set)
        for key, choices in offered.items():
            for each in filter(None, choices):
                treats[each.repair.id].add(key)
        made: dict[MoveKey, Move] = {}
        for key, choices in offered.items():
            mine = []
            for option in choices:
                if option is None:
                    move = Move(None, (key,), frozenset({key}))
                else:
                    move = Move(option, option.lands, frozenset(treats[option.repair.id]))
                mine.append(made.setdefault(move.key, move))
            self.of_land[key] = tuple(mine)
        self.all = tuple(made.values())
        self.states: dict[LandKey, list[LandClearance]] = defaultdict(list)
        self._numbers: dict[tuple[MoveKey, LandKey], int] = {}
        measured = {land.key: land.state for land in lands}
        for move in self.all:
            for key in move.lands:
                (new,) = repaired([measured[key]], [key]) if move.option is None else (move.option.states[key],)
                self.states[key].append(new)
                self._numbers[move.key, key] = len(self.states[key])

    @property
    def currencies(self) -> tuple[str, ...]:
        """Return the currencies in which prices of the offered repairs are known; those of two are not compared."""
        priced = (move for move in self.all if self.prices.price(move) is not None)
        return tuple(dict.fromkeys(map(self.prices.currency_of, priced)))

    def _wanted(self, kept: Iterable[str]) -> Iterator[tuple[LandKey, Option]]:
        """Yield the lands that the workshop's repairs change, each with its one."""
        by_id, taken = {option.repair.id: option for option in self.options.all}, set[LandKey]()
        for name in (*(repair.id for repair in self.options.of_workshop), *kept):
            option = by_id.get(name)
            if option is not None and taken.isdisjoint(option.states):
                taken |= option.states.keys()
                yield from ((key, option) for key in option.states)

    def _offered(self, land: LandDiagnosis, *, as_new: bool) -> list[Option | None]:
        key, wanted = land.key, self.wanted.get(land.key)
        if wanted is not None:
            return [wanted]
        able: list[Option | None] = []
        for option in self.options.of(key):
            others = (self.wanted.get(each) for each in option.lands)
            if option.mends(key) and all(other in (None, option) for other in others):
                able.append(option)
        priced = [option for option in able if option is not None and self._priced(option)]
        able = [each for each in able if each in priced or not self._replaceable(each, priced)]
        tighter = land.state.land.new_clearance < land.state.radial_clearance
        if as_new or (not able and (tighter or land.verdict.flagged)):
            able.append(None)
        return able

    def _priced(self, option: Option) -> bool:
        return self.prices.cost(Move(option, option.lands, frozenset())) is not None

    def _replaceable(self, option: Option | None, priced: Iterable[Option]) -> bool:
        """Tell whether every flagged land that an option without a price mends is mended by others that have one."""
        if option is None:
            return False
        everywhere = {key for each in self.options.all if self._priced(each) for key in each.mending}
        return any(priced) and option.mending & self._flagged <= everywhere

    def state_after(self, move: Move, key: LandKey) -> int:
        """Return the number of the state in which a repair leaves a land."""
        return self._numbers[move.key, key]

    def choice(self, chosen: Iterable[Move]) -> LandChoice:
        """Return the state of every land after some repairs; one that is made as new is so whatever else changes it."""
        states: dict[LandKey, int] = {}
        for move in sorted(chosen, key=lambda move: move.option is None):
            states |= {key: self.state_after(move, key) for key in move.lands}
        return states


def pump_option(options: Options, prices: Prices, kept: Collection[str] = ()) -> Option | None:
    """Return the repair of the pump that is planned, None where the file names none.

    It is the one that the workshop chose, or that is ``kept``; else the cheapest of those that have a price, and the
    first where these are in several currencies or none has one.
    """
    offered = options.of_pump
    wanted = [each for each in offered if each.repair in options.of_workshop or each.repair.id in kept]
    moves = [Move(each, (), frozenset()) for each in wanted or offered]
    priced = [move for move in moves if prices.cost(move) is not None]
    if len(set(map(prices.currency_of, priced))) < 2:
        priced.sort(key=lambda move: prices.cost(move) or Decimal(0))
    return next((move.option for move in [*priced, *moves]), None)


def together(moves: Iterable[Move]) -> list[Move]:
    """Return as many repairs as go together, those of most lands first."""
    chosen: list[Move] = []
    for move in sorted(moves, key=lambda move: -len(move.treats)):
        if all(move.goes_with(other) for other in chosen):
            chosen.append(move)
    return chosen
