"""Check on simulated units, each with one cause that is known, that atleak names it and blames no sound part.

    python benchmarks/causes.py [--small] [--case NAME] [--valve-body NAME] [--units N] [--misses]

Units of shipped valve bodies (`simulated/faulty.py`) are diagnosed from a measuring sheet and gauge readings like any
other job. Counted by case: of units whose cause truly costs a measured pressure `WORTH` or more, how many have it
named; of all units, in how many a sound part is named, how often the 95 % intervals of what is missing and of what each
cause explains hold the truth (the same split, made of the true unit by the engine alone), and what a job costs.
`--misses` prints each unit that is not named right. Exits with 1 where a stated rate is not met.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

from simulated.faulty import CASES, GAUGE, UNITS, Case, Job, instruments, job_of
from timing import options

from atleak.analysis.answer import Answer, answer_of
from atleak.catalogue.limits import load_limits
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.examination import diagnose
from atleak.diagnosis.missing import Amount, Cause, Missing
from atleak.diagnosis.uncertainty import DEFAULTS

OPTIONS = options(__doc__)
OPTIONS.add_argument("--units", type=int, default=20, help="units of each valve body in each case")
OPTIONS.add_argument("--case", action="append", choices=[case.name for case in CASES], help="only this one, or several")
OPTIONS.add_argument("--valve-body", action="append", help="only this one, or several")
OPTIONS.add_argument("--workers", type=int, default=1)
OPTIONS.add_argument("--misses", action="store_true", help="print each unit of which the cause is not named right")
WORTH = 100e3  # [Pa]
BLAMED, HOLD, CPU = 1.0, 93.0, 4.0  # [%] at most, [%] at least, [s] at most
NOTHING = 1e3  # [Pa] that nobody reads off a gauge: by so much the truth may lie outside
SMALL_UNITS, SMALL_SPARE = 2, 40.0  # units of a small run; percentage points it may miss


def main(arguments: argparse.Namespace) -> int:
    started, failures = time.perf_counter(), []
    units, spare = (SMALL_UNITS, SMALL_SPARE) if arguments.small else (arguments.units, 0.0)
    bodies = arguments.valve_body or UNITS[1:2] if arguments.small else arguments.valve_body or UNITS
    whole: Counter[str] = Counter()
    with ProcessPoolExecutor(arguments.workers) as pool:
        for case in (each for each in CASES if not arguments.case or each.name in arguments.case):
            jobs = [(body, number) for body in bodies if body in case.bodies for number in range(units)]
            counts: Counter[str] = Counter()
            for found, misses in pool.map(partial(counted, case), *zip(*jobs, strict=True)) if jobs else ():
                counts += found
                if arguments.misses:
                    print(*misses, sep="\n", end="\n" if misses else "")
            named = percent(counts, "named", "worth")
            print(
                f"{case.name}: named {named:.0f} % of {counts['worth']}, sound part blamed {counts['blamed']} of "
                f"{counts['jobs']}, missing held {percent(counts, 'missing held', 'missing'):.0f} %, rows "
                f"{percent(counts, 'row held', 'row'):.0f} % of {counts['row']}, {seconds(counts):.1f} s of CPU a job",
                flush=True,
            )
            whole += counts
            short = counts["worth"] and named < case.least - spare
            failures += [f"{case.name}: {named:.0f} % named, goal {case.least:.0f}"] if short else []
    blamed = percent(whole, "blamed", "jobs")
    failures += [f"{blamed:.1f} % blame a sound part, goal {BLAMED}"] if blamed > BLAMED + spare else []
    for what in ("missing", "row"):
        held = percent(whole, f"{what} held", what)
        print(f"95 % intervals of {what}: {held:.1f} % of {whole[what]} hold the truth")
        failures += [f"{what}: {held:.1f} % held, goal {HOLD}"] if whole[what] and held < HOLD - spare else []
    failures += [f"{seconds(whole):.1f} s a job, goal {CPU}"] if seconds(whole) > CPU else []
    print(f"\n{time.perf_counter() - started:.0f} s, {arguments.workers} processes; sound part blamed {blamed:.1f} %")
    print("\n".join(failures) or "All stated rates are met.")
    return 1 if failures else 0


def percent(counts: Counter[str], part: str, of: str) -> float:
    return 100.0 * counts[part] / max(counts[of], 1)


def seconds(counts: Counter[str]) -> float:
    """Return the CPU time of a job [s]."""
    return 1e-3 * counts["cpu ms"] / max(counts["jobs"], 1)


def counted(case: Case, body: str, number: int) -> tuple[Counter[str], list[str]]:
    """Diagnose one unit, count what is said of it, and describe it where its cause is not named right."""
    job = job_of(case, body, number)
    began = time.process_time()
    diagnosis = diagnose(
        job.controller,
        job.fluid,
        load_limits("project_default"),
        readings=job.readings,
        pressures=job.table,
        pump_clearances=job.pump,
        instruments=instruments(),
        assumptions=replace(DEFAULTS, main_pressure=GAUGE),
    )
    answer = answer_of(diagnosis)
    counts = Counter({"jobs": 1, "cpu ms": round(1000.0 * (time.process_time() - began))})
    worth = job.cost >= WORTH or not case.cause
    right, wrong = named(job, answer), blamed(job, answer)
    counts += Counter({"worth": worth, "named": worth and right, "blamed": wrong})
    outside = []
    for what, amount, true in compared(job, diagnosis):
        holds = (
            amount.low is not None and amount.high is not None and amount.low - NOTHING <= true <= amount.high + NOTHING
        )
        kind = "missing" if what.endswith("missing") else "row"
        counts += Counter({kind: 1, f"{kind} held": holds})
        outside += [] if holds else [f"{what} {true / 1e3:.0f} not in {_kpa(amount)}"]
    if wrong or (worth and not right):
        return counts, [f"  {case.name} {body} {number}: {job}", f"    {said(answer)}", f"    {'; '.join(outside)}"]
    return counts, [f"  {case.name} {body} {number}: {'; '.join(outside)}"] if outside else []


def named(job: Job, answer: Answer) -> bool:
    """Return whether the true cause is named: of lands one that is worn, or a circuit of which one is."""
    case, causes = job.case, (answer.cause, *answer.also)
    if not case.cause:
        return answer.cause in (Cause.UNEXPLAINED, Cause.NONE)
    if case.one_speed and answer.cause is Cause.UNEXPLAINED:
        return Cause.PUMP in causes
    if answer.cause in (Cause.LANDS, Cause.LINE_SETTING) and answer.land in job.true.faults.wear:
        return True  # a land may cost a circuit of its own beside the one that the line follows
    if answer.cause is not case.cause:
        return False
    if case.cause is Cause.LANDS:
        return answer.circuit in {job.circuit_of(key) for key in job.true.faults.wear}
    return case.cause is not Cause.CLUTCH_SEAL or answer.circuit in job.true.faults.seals


def blamed(job: Job, answer: Answer) -> bool:
    """Return whether a part is named that is sound."""
    faults = job.true.faults
    if answer.cause is Cause.PUMP:
        return faults.slip == 1.0
    if answer.cause is Cause.CLUTCH_SEAL:
        return answer.circuit not in faults.seals
    return answer.land is not None and answer.land not in faults.wear


def compared(job: Job, diagnosis: Diagnosis) -> Iterator[tuple[str, Amount, float]]:
    """Yield what is said of every measured pressure with its interval, beside the truth [Pa]."""
    for missing in (each for each in diagnosis.missing_measured if not each.doubted):
        where = f"{missing.point.name} {missing.point.engine_speed * 60:.0f} {missing.tap}"
        total, rows = job.truth(missing.point, missing.tap)
        yield f"{where} missing", missing.amount(lambda each: each.missing), total
        for row in dict.fromkeys([*rows, *missing.rows]):
            amount, true = missing.amount(partial(Missing.of_row, row=row)), rows.get(row, 0.0)
            if row[0] is Cause.CLUTCH_SEAL and row not in missing.rows:
                continue  # is part of what is unexplained
            if max(map(abs, (*filter(None, amount), true))) >= NOTHING:
                yield f"{where} {row[0]}{f' of {row[1]}' if row[1] else ''}", amount, true


def said(answer: Answer) -> str:
    missing = answer.missing
    if missing is None:
        return str(answer.cause)
    rows = {row: missing.amount(partial(Missing.of_row, row=row)) for row in answer.amounts}
    return (
        f"{answer.cause} {answer.circuit} {answer.land} also {[*map(str, answer.also)]} p {answer.probability}: "
        f"{missing.point.name} {missing.tap} missing {_kpa(missing.amount(lambda each: each.missing))}, "
        + ", ".join(f"{row[0]} {row[1]} {_kpa(amount)}" for row, amount in rows.items())
        + f", unexplained {_kpa(missing.amount(lambda each: each.unexplained))}, seal {missing.split.seal_worn:.2f}"
    )


def _kpa(amount: Amount) -> str:
    return " ".join("-" if each is None else f"{each / 1e3:.0f}" for each in amount)


if __name__ == "__main__":
    sys.exit(main(OPTIONS.parse_args()))
