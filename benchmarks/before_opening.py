"""Check on simulated units that gauges alone say what is worn, before anything is opened.

    python benchmarks/before_opening.py [--small] [--valve-body NAME] [--units N] [--brute N]
        [--gauge FRACTION] [--gauges one|two|each]

Units are drawn from what `Assumptions` states of a unit before any gauge is read (`simulated/unopened.py`); those count
in which one land alone costs the line or a tapped circuit `FAULT` or more. One gauge goes from tap to tap, and errs
alike in all that it shows but for a tenth of its variance (`--gauges two`: another stays on the line; `each`: every
reading errs by itself); lands are not measured. Counted is what `evidence_of` says:

- land: the one that costs most is among the first three; in brackets where no other costs `FAULT`;
- group: it, or one that no gauge can tell from it, is first, and among the first three that are told apart;
- circuit: the one that has lost most is first;
- found, false: circuits that have truly lost the first limit or more, and those that have not, whose probability of it
  is `LIKELY` or more;
- calibration: of what is said with a probability in one tenth, how much is true, where that is said `CASES` times.
  That is counted of as many units as they are drawn: one that was chosen for its fault is worse than its gauges tell;
- CPU time of a job, diagnosis included.

Beside it the same is counted of what can be known: of the first `--brute` units, by brute force, where that comes to
`FEW` draws of equal weight or more. Other valve bodies have no goals. Exits with 1 where one of the five-speed's
is not met.
"""

from __future__ import annotations

import argparse
import math
import sys
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cache, partial

import numpy as np
from scipy.stats import binomtest
from simulated.gauged import file_of
from simulated.unopened import LAND, NEW, Bank, Gauges, Known, Prior, Unit, costs_of, faulty, made_new
from timing import options

from atleak.catalogue.limits import load_limits
from atleak.catalogue.repairs import LandKey
from atleak.diagnosis.evidence import LIKELY, evidence_of
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.uncertainty import DEFAULTS
from atleak.engine.operation import LINE

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=500, help="units with a fault of each valve body")
OPTIONS.add_argument("--valve-body", action="append", help="only this one, or several")
OPTIONS.add_argument("--gauge", action="append", type=float, help="relative, only this one, or several")
OPTIONS.add_argument(
    "--gauges",
    choices=["one", "two", "each"],
    default="one",
    help="one for all taps, another on the line, or unlike each time",
)
OPTIONS.add_argument(
    "--brute", type=int, default=100, help="units of the five-speed that are worked out by brute force"
)
OPTIONS.add_argument("--workers", type=int, default=1)
FIVE_SPEED = "five_speed_2005"
VALVE_BODIES = (FIVE_SPEED, "aisin_aw55_50sn", "chrysler_41te", "ford_4r70w", "gm_4l60e", "jatco_jf506e", "zf_6hp26")
GOALS = {0.02: (80.0, 85.0, 72.0), 0.005: (93.0, 96.0, 92.0)}  # [%] of lands, circuits and losses, by the gauge
FALSE, NEAR, CPU = 0.5, 3.0, 5.0  # [%] of circuits at most, percentage points to brute force, [s] at most
FAULT = 20e3  # [Pa] that a land costs: less is nobody's complaint
CASES, FIRST, FEW, EQUAL, TRIED = 30, 3, 100, 2_048, 8
LIMITS = load_limits("project_default")
assert LIMITS.wear
assert LIMITS.circuit_loss
(WATCH, GROWTH), LIMIT = LIMITS.wear.levels[0], LIMITS.circuit_loss.levels[0][1]
WIDER = LIMITS.wear.at_least[WATCH]  # [m] that a land has worn at least, to be past it
BANK, DRAWS, MOST = 500_000, 8_192, 65_536
PORTION = 10


@dataclass(frozen=True)
class Said:
    """What is said of a unit, in its order."""

    lands: Mapping[LandKey, float]  # probability that it is worn past its first limit
    circuits: Mapping[str, float]  # that it has lost more than its first limit


@dataclass
class Counts:
    """What is counted of some units."""

    numbers: Counter[str] = field(default_factory=Counter)
    #: of circuits and of lands, with which probability something is said, and whether it is so
    said: dict[str, list[tuple[float, bool]]] = field(default_factory=dict)

    def __add__(self, other: Counts) -> Counts:
        both = self.said | other.said
        said = {what: [*self.said.get(what, ()), *other.said.get(what, ())] for what in both}
        return Counts(self.numbers + other.numbers, said)

    def percent(self, part: str, of: str = "units") -> float:
        return 100.0 * self.numbers[part] / max(self.numbers[of], 1)

    @property
    def rates(self) -> tuple[float, float, float]:
        """Return how often the land is among the first three, the circuit first, a loss found [%]."""
        return self.percent("land"), self.percent("circuit"), self.percent("found", "lost")

    @property
    def seconds(self) -> float:
        """Return the CPU time of a job [s]."""
        return 1e-5 * self.percent("cpu ms")

    def __str__(self) -> str:
        land, circuit, found = self.rates
        alone = f"{self.percent('land alone', 'alone'):.1f} % of {self.numbers['alone']}"
        groups = " and ".join(f"{self.percent(name):.1f}" for name in ("group", "of groups"))
        return (
            f"land {land:.1f} % ({alone}), group {groups} %, circuit {circuit:.1f} % of {self.numbers['units']}; "
            f"found {found:.1f} % of {self.numbers['lost']}, "
            f"false {self.percent('alarms', 'sound'):.2f} % of {self.numbers['sound']}"
        )


def main(arguments: argparse.Namespace) -> int:
    started, failures = time.perf_counter(), []
    units, brute, bank = (4, 1, 2 * DRAWS) if arguments.small else (arguments.units, arguments.brute, BANK)
    bodies = arguments.valve_body or VALVE_BODIES[: 1 if arguments.small else None]
    with ProcessPoolExecutor(arguments.workers) as pool:
        for relative in arguments.gauge or [*GOALS][: 1 if arguments.small else None]:
            for body in bodies:
                gauges, parts = Gauges(relative, arguments.gauges), [*portions(units)]
                count = partial(counted, body, gauges, units, bank, brute if body == FIVE_SPEED else 0)
                ours, same, known = map(sum_of, zip(*pool.map(count, parts), strict=True))
                name = f"{body}, gauges {100.0 * relative:g} %"
                print(f"{name}: {ours}, {ours.seconds:.1f} s of CPU a job", flush=True)
                if body == FIVE_SPEED and not arguments.small:
                    goals = GOALS.get(relative, (0.0, 0.0, 0.0))
                    failures += [f"{name}: {each}" for each in (*short_of(ours, goals), *uncalibrated(ours))]
                    failures += [f"{name}: {each}" for each in short_of(same, [rate - NEAR for rate in known.rates])]
                if known.numbers["units"]:
                    print(f"    of those worked out by brute force: {same}\n    by brute force: {known}", flush=True)
    print(f"\n{time.perf_counter() - started:.0f} s, {arguments.workers} processes")
    print("\n".join(failures) or "All stated rates are met.")
    return 1 if failures else 0


def portions(units: int) -> Iterator[range]:
    return (range(start, min(start + PORTION, units)) for start in range(0, units, PORTION))


def sum_of(counts: Iterable[Counts]) -> Counts:
    return sum(counts, Counts())


def short_of(counts: Counts, goals: Sequence[float]) -> Iterator[str]:
    """Say which rates fall short of their goals, and whether more circuits are accused than may be."""
    for what, rate, goal in zip(("land", "circuit", "found"), counts.rates, goals, strict=True):
        if rate < goal:
            yield f"{what} {rate:.1f} %, goal {goal:.1f}"
    if counts.seconds > CPU:
        yield f"{counts.seconds:.1f} s a job, goal {CPU}"
    if counts.percent("alarms", "sound") > FALSE:
        yield f"{counts.percent('alarms', 'sound'):.2f} % false, goal {FALSE}"


def uncalibrated(counts: Counts) -> Iterator[str]:
    """Print of each tenth of the probabilities with `CASES` how much is so, and say where that is not what is said."""
    for what, said in counts.said.items():
        stated, so = np.array(said, float).T
        tenth = np.minimum((10.0 * stated).astype(int), 9)
        for number in np.flatnonzero(np.bincount(tenth) >= CASES):
            here = tenth == number
            interval = binomtest(int(so[here].sum()), int(here.sum())).proportion_ci(0.95, "exact")
            mean = float(stated[here].mean())
            line = (
                f"{what} said with {mean:.3f} on average: {so[here].mean():.3f} of {here.sum()} so, "
                f"{interval.low:.3f} to {interval.high:.3f}"
            )
            print(f"    {line}")
            if not interval.low <= mean <= interval.high:
                yield line


@cache
def units_of(body: str, count: int) -> tuple[Prior, list[Unit]]:
    """Return so many units with a fault of a valve body, the same each time; fewer where it has hardly any."""
    prior = Prior(*file_of(body), DEFAULTS)
    return prior, faulty(prior, FAULT, TRIED * count)[:count]


@cache
def any_units_of(body: str, count: int) -> list[Unit]:
    """Return so many units of a valve body as they are drawn, the same each time."""
    return faulty(Prior(*file_of(body), DEFAULTS), -math.inf, count)


@cache
def bank_of(body: str, count: int) -> Bank:
    return Bank(Prior(*file_of(body), DEFAULTS), count)


def counted(
    body: str, gauges: Gauges, units: int, bank: int, brute: int, numbers: range
) -> tuple[Counts, Counts, Counts]:
    """Count over some units: what atleak says of all, what it says of those that brute force tells of, and that."""
    prior, faults = units_of(body, units)
    ours, same, known = Counts(), Counts(), Counts()
    for number in range(numbers.start, min(numbers.stop, len(faults))):
        unit, rng = faults[number], np.random.default_rng((20261128, number))
        showed = gauges.read(rng, prior.taps, unit.held)
        began = time.process_time()
        said, groups = said_by_gauges(body, prior, gauges, showed)
        spent = Counter({"cpu ms": round(1000.0 * (time.process_time() - began))})
        found = judged(prior, unit, said, groups)
        ours += Counts(found.numbers + spent)
        any_unit = any_units_of(body, units)[number]
        there = said_by_gauges(body, prior, gauges, gauges.read(rng, prior.taps, any_unit.held))
        ours += Counts(said=judged(prior, any_unit, *there).said)
        if number < brute:
            by_force = bank_of(body, bank).known(rng, gauges, showed, draws=DRAWS, most=min(MOST, bank))
            if by_force.effective >= FEW:
                same, known = same + found, known + judged(prior, unit, said_of(prior, by_force), groups)
    return ours, same, known


def said_by_gauges(
    body: str, prior: Prior, gauges: Gauges, showed: np.ndarray
) -> tuple[Said, Mapping[LandKey, object]]:
    """Return what atleak says of a unit by its gauges alone, and which lands it cannot tell apart."""
    table, assumptions = gauges.table(prior, showed), replace(DEFAULTS, main_pressure=gauges.relative)
    evidence = evidence_of(diagnose(*file_of(body), LIMITS, pressures=table, assumptions=assumptions))
    said = Said(
        {each.land.key: each.probability for each in evidence.lands},
        {each.circuit.id: each.probability for each in evidence.circuits},
    )
    return said, {each.land.key: each.group or each.land.key for each in evidence.lands}


def judged(prior: Prior, unit: Unit, said: Said, groups: Mapping[LandKey, object]) -> Counts:
    """Count what is said of one unit."""
    lands, circuits = [*said.lands], [*said.circuits]
    lost = {
        tap: max(loss for loss, (_, at) in zip(unit.lost, prior.taps, strict=True) if at == tap)
        for tap in dict.fromkeys(tap for _, tap in prior.taps if tap != LINE)
    }
    numbers = Counter({"units": 1})
    numbers["land"] += unit.worst in lands[:FIRST]
    if sum(cost >= FAULT for cost in unit.costs.values()) == 1:
        numbers["alone"] += 1
        numbers["land alone"] += unit.worst in lands[:FIRST]
    apart = [*dict.fromkeys(groups[key] for key in lands)]
    numbers["group"] += apart[0] == groups[unit.worst]
    numbers["of groups"] += groups[unit.worst] in apart[:FIRST]
    numbers["circuit"] += next(each for each in circuits if each in lost) == max(lost, key=lambda each: lost[each])
    for tap, loss in lost.items():
        numbers["lost" if loss >= LIMIT else "sound"] += 1
        numbers["found" if loss >= LIMIT else "alarms"] += said.circuits[tap] >= LIKELY
    of_lands = [(said.lands[key], bool(worn(unit.parts[LAND, key], unit.parts[NEW, key]))) for key in prior.lands]
    of_circuits = [(said.circuits[tap], bool(loss >= LIMIT)) for tap, loss in lost.items()]
    return Counts(numbers, {"land": of_lands, "circuit": of_circuits})


def said_of(prior: Prior, known: Known) -> Said:
    """Return the same by brute force."""
    units, held = known.equally_likely(EQUAL)
    lost = prior.held(made_new(units)) - held
    circuits: dict[str, tuple[float, float]] = {}
    for (_, tap), each in zip(prior.taps, lost, strict=True):
        if tap != LINE:
            circuits[tap] = max(circuits.get(tap, (0.0, 0.0)), (float(np.mean(each >= LIMIT)), float(np.mean(each))))
    costs = dict(zip(prior.lands, costs_of(prior, units, held).mean(axis=1), strict=True))
    lands = sorted(prior.lands, key=lambda each: -costs[each])
    return Said(
        {key: float(known.weights @ worn(known.units[LAND, key], known.units[NEW, key])) for key in lands},
        {name: each[0] for name, each in sorted(circuits.items(), key=lambda each: each[1], reverse=True)},
    )


def worn(gone: np.ndarray, new: np.ndarray) -> np.ndarray:
    """Return whether lands are worn past the first limit of wear."""
    return np.asarray(gone >= np.maximum(GROWTH * new, WIDER))


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
