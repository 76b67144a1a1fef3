"""Sum up a fleet from its data sets: verdicts, wear over mileage, the worst pairs, temperatures, groups, errors.

Only the columns that are needed are read, one valve body after another; no job is opened.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from atleak.common.errors import FleetError, Message, Place
from atleak.common.sentences import Sentence
from atleak.common.verdicts import Verdict
from atleak.diagnosis.uncertainty import DECISIONS
from atleak.fleet.columns import ERROR_KINDS, HASH, PARTITION
from atleak.fleet.counts import (
    Lands,
    UnitVisits,
    conditions_of,
    counts_of,
    deciders_of,
    groups_of,
    read_lands,
    read_visits,
    temperatures_of,
    troubles_of,
    wear_by_mileage,
)
from atleak.fleet.groups import compared
from atleak.fleet.results import Results
from atleak.fleet.sums import LISTED, ErrorCount, FleetSummary, SummedUnit, ValveBody
from atleak.version import __version__

_MESSAGES = 5  # of errors of one kind that are told
_DIAGNOSED_WITH = ("controller_sha256", "limits_sha256", "fluid_sha256", "profile")
_AS_THEY_ARE = (HASH, PARTITION, "reference", "name", "group", "label", "number", "vin", "serial", "decision")


def summed_up(
    results: Results, *, by: str | None = None, controller: str | None = None, listed: int = LISTED
) -> FleetSummary:
    """Sum up the results of a fleet.

    Parameters
    ----------
    by
        heading of a label, or ``group``, whose values are compared.
    controller
        id of the only valve body to be summed up; all of them unless given.
    listed
        how many units are listed, the worst first.

    Raises
    ------
    FleetError
        There is neither a result nor an error; a part that is damaged.
    InputError
        No unit states such a heading, too many different things stand there, or none is of such a valve body.
    """
    errors = tuple(_errors(results, controller))
    if not errors and not results.controllers():
        problem = Sentence("holds no unit yet, neither a result nor an error")
        expected = Sentence("results of a run that has begun to write")
        raise FleetError(problem, place=Place(file=str(results.folder)), expected=expected)
    visits = read_visits(results, by=by, controller=controller)
    bodies, past = [], []
    for each in visits.rows[PARTITION].unique():
        mine = visits.of(each)
        lands = read_lands(results, each, mine)
        bodies.append(_body(results, each, mine, lands))
        past.append(pd.Series(_past(lands), index=visits.rows.index[visits.rows[PARTITION] == each]))
    units = visits.counted.assign(past=pd.concat(past) if past else 0)
    return FleetSummary(
        folder=str(results.folder),
        atleak=str(visits.rows["atleak"].iloc[0]) if len(visits.rows) else __version__,
        by=visits.by,
        visits=len(visits.rows),
        counts=counts_of(units),
        groups=groups_of(units),
        not_stated=int(units["label"].isna().sum()) if visits.by is not None else 0,
        headings=visits.headings,
        bodies=tuple(sorted(bodies, key=lambda body: (-body.counts.units, body.controller))),
        errors=errors,
        worst=tuple(_worst(units, visits, listed)),
        messages=tuple(_messages(visits.rows)),
    )


def _body(results: Results, controller: str, visits: UnitVisits, lands: Lands) -> ValveBody:
    units = visits.counted
    of_units = lands.at(visits.rows["counts"].to_numpy())
    counts, deciders = counts_of(units), deciders_of(units)
    return ValveBody(
        controller=controller,
        visits=len(visits.rows),
        counts=counts,
        deciders=deciders,
        pairs=troubles_of(of_units, deciders, counts.judged),
        wear=wear_by_mileage(visits, lands),
        temperatures=temperatures_of(results, controller, visits),
        conditions=conditions_of(results, controller, visits),
        comparison=compared(units, of_units),
        messages=tuple(_body_messages(units)),
        name=next(iter(sorted(visits.rows["controller_name"].dropna().mode())), None),
    )


def _past(lands: Lands) -> np.ndarray:
    """Return how many lands of each visit are at *replace* or past it."""
    past: np.ndarray = (lands.rank >= Verdict.REPLACE.rank).sum(axis=1)
    return past


def _worst(units: pd.DataFrame, visits: UnitVisits, listed: int) -> Iterator[SummedUnit]:
    """Yield the worst units: by verdict, how sure it is, and how many lands are to be replaced; then by share."""
    ranked = units.assign(
        rank=units["verdict"].map({str(verdict): verdict.rank for verdict in Verdict}).fillna(0),
        sure=units["decision"].map({decision: number for number, decision in enumerate(DECISIONS)}).fillna(-1),
    )
    order = ["rank", "sure", "past", "max_share_percent"]
    worst = ranked.sort_values([*order, "reference"], ascending=[*(False for _ in order), True]).head(listed)
    times = visits.rows["unit"].value_counts()
    for row in worst.to_dict("records"):
        yield _listed(row, int(times[row["unit"]]))


def _listed(row: Mapping[Hashable, Any], visits: int) -> SummedUnit:
    kind, component, land = row["decided_by_kind"], row["decided_by_component"], row["decided_by_land"]
    own = {name: _or_none(row[name]) for name in _AS_THEY_ARE}
    return SummedUnit(
        **own,
        date=None if pd.isna(row["day"]) else row["day"].date(),
        mileage_km=_or_none(row["mileage_km"]),
        verdict=Verdict(row["verdict"]),
        provisional=row["provisional"],
        decided_by=_or_none(kind) if pd.isna(land) else (component, int(land)),
        lands_past=int(row["past"]),
        max_share_percent=_or_none(row["max_share_percent"]),
        visits=visits,
        lands_measured=int(row["lands_measured"]),
        lands_total=None if pd.isna(row["lands_total"]) else int(row["lands_total"]),
    )


def _or_none(value: Any) -> Any:
    return None if pd.isna(value) else value


def _errors(results: Results, controller: str | None) -> Iterator[ErrorCount]:
    """Yield the kinds of errors; of one valve body's summary also of files whose valve body is not known."""
    rows = results.table("errors", ["name", "kind", "message", PARTITION]).to_pandas()
    if controller is not None:
        rows = rows[rows[PARTITION].isna() | (rows[PARTITION] == controller)]
    for kind in ERROR_KINDS:
        mine = rows[rows["kind"] == kind].sort_values("name")
        if len(mine):
            first = mine.drop_duplicates("message").head(_MESSAGES)
            yield ErrorCount(kind, len(mine), tuple(zip(first["name"], first["message"], strict=True)))


def _messages(rows: pd.DataFrame) -> Iterator[Message]:
    alone = int((~rows["told"]).sum())
    if alone:
        text = Sentence(
            "{count} of {all} results state neither a serial number nor a VIN: each counts as a unit of its own.",
            count=alone,
            all=len(rows),
        )
        yield Message("info", "not_told_apart", text)


def _body_messages(units: pd.DataFrame) -> Iterator[Message]:
    """Yield what makes units of one valve body not comparable with one another."""
    various = {name: units[name].nunique() for name in _DIAGNOSED_WITH}
    sentences = {
        "controller_sha256": Sentence(
            "The units were diagnosed with {count} different descriptions of this valve body.",
            count=various["controller_sha256"],
        ),
        "limits_sha256": Sentence(
            "The units were judged by {count} different sets of limits: their verdicts do not say the same.",
            count=various["limits_sha256"],
        ),
        "fluid_sha256": Sentence(
            "The units were diagnosed with {count} different fluids: their shares and pressures depend on it.",
            count=various["fluid_sha256"],
        ),
        "profile": Sentence(
            "The units were diagnosed with {count} different profiles: their shares and pressures depend on it.",
            count=various["profile"],
        ),
    }
    for name, text in sentences.items():
        if various[name] > 1:
            yield Message("warning", f"various_{name.removesuffix('_sha256')}", text)
