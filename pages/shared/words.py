"""Write the sentences and rows that a page shows, from the record: only words and choice of columns."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from atleak.catalogue.controller import Controller
from atleak.diagnosis import Diagnosis, LandDiagnosis
from atleak.engine.projection import Projection
from atleak.rules import Rule
from atleak.verdicts import FLAGGED, Band, Verdict
from atleak.views.caveats import caveat_marks, caveats
from atleak.views.condition_matrix import LandAtCondition, MatrixRow
from atleak.views.measured_words import measured_sentence
from atleak.views.pressures import worst_pressure
from atleak.views.sentences import because_of, covered_from, replace_at
from atleak.wording import Wording, signed, wording
from atleak.workshop_units import PERCENT
from pages.shared.show import plain

PARTLY = ("spool_only", "sleeve_only")
DIGITS = {
    "Clearance [µm]": 1,
    "u [µm]": 1,
    "Mounting [µm]": 1,
    "Wear [%]": 1,
    "Share [%]": 2,
    "Largest share [%]": 2,
    "Over it [%]": 1,
    **dict.fromkeys(("Leakage [dm³/min]", "from", "to"), 3),
    "Spool [mm]": 4,
    "Sleeve [mm]": 4,
    "Least [µm]": 1,
    "Largest [µm]": 1,
    "At [°]": 0,
    **dict.fromkeys(
        (f"{part} {what} [µm]" for what in ("ovality", "taper", "spread") for part in ("Spool", "Sleeve")), 1
    ),
}


def verdict_sentence(diagnosis: Diagnosis, record: dict[str, Any]) -> str:
    """Return the verdict in one paragraph, in markdown; without a sheet what gauges and log say."""
    say = wording("en")
    marks = [f"**{mark.capitalize()}.** " for mark in caveat_marks(diagnosis, say)]
    reasons = [f"\n\n{plain(each)}" for each in caveats(diagnosis, say)]
    return "".join([*marks, _verdict_sentence(diagnosis, record, say), *reasons])


def _verdict_sentence(diagnosis: Diagnosis, record: dict[str, Any], say: Wording) -> str:
    measured = measured_sentence(diagnosis, say)
    if measured is not None and diagnosis.without_sheet:
        return f"**{signed(diagnosis.verdict)}** {plain(measured)} {plain(say('findings.alone'))}"
    lands = record["lands"]
    counts = {level: sum(land["verdict"] == level for land in lands) for level in reversed(FLAGGED)}
    flagged = " and ".join(f"**{count} {signed(name)}**" for name, count in counts.items() if count)
    whole = sum(land["measured"] == "measured" for land in lands)
    partly = sum(land["measured"] in PARTLY for land in lands)
    open_ones = sum(land["measured"] in PARTLY and land["verdict"] == "not_measured" for land in lands)
    if flagged:
        pairs = len({land["component"] for land in lands if land["verdict"] in FLAGGED})
        where = f"{pairs} component{'s' * (pairs != 1)}"
        head = f"{flagged} of {whole + partly} measured land{'s' * (whole + partly != 1)}, in {where}."
    elif whole:
        sign = "None" if isinstance(diagnosis.decided_by, Rule) else f"**{signed(Verdict.OK)}:** none"
        head = f"{sign} of {whole} measured land{'s' * (whole != 1)} has reached a limit of its own."
    elif partly:
        head = f"**{signed(Verdict.NOT_MEASURED)}:** no land is measured on both spool and sleeve."
    else:
        new = f"all {len(lands)} are at their mounting clearance"
        head = f"**{signed(Verdict.NOT_MEASURED)}:** no land is measured; {new}."
    if measured is not None:
        head = f"**{signed(diagnosis.verdict)}** because of main pressure: {plain(measured)} {head}"
    elif isinstance(diagnosis.decided_by, Rule):
        because = because_of(diagnosis, diagnosis.decided_by, say) or f"because of the {diagnosis.decided_by.label}."
        head = f"**{signed(diagnosis.verdict)}** {plain(because)} {head}"
    elif diagnosis.decided_by is not None:
        head += f" Decided by **{plain(land_name(diagnosis, diagnosis.decided_by.key))}**."
        pressure = worst_pressure(diagnosis)
        if pressure is not None:
            because = because_of(diagnosis, pressure, say) or ""
            head += f" Pressure: **{signed(pressure.verdict)}** {plain(because)}"
    if open_ones:
        head += f" {open_ones} measured on the spool or the sleeve only cannot be called ok."
    several = len(diagnosis.projections) > 1
    totals = [_total(row, worst=several and at is diagnosis.worst) for at, row in reported(diagnosis, record)]
    covers = f"At {plain(diagnosis.worst.condition.label)} {plain(covered_from(diagnosis, diagnosis.worst))}."
    return f"{head} The unit leaks {listed(totals)}. {covers}"


def _total(point: dict[str, Any], *, worst: bool) -> str:
    share, label = point["share_percent"], plain(point["label"])
    mark = ", the worst condition" if worst else ""
    if point["band"] is None:  # not measured
        return f"**{'more than all' if share is None else f'{share:.1f} %'}** of the pump's flow at {label} when new"
    band = Band(point["band"])
    if share is None:
        return f"more than the pump delivers at {label} ({signed(Band.CRITICAL)}{mark})"
    new = "" if point["share_new_percent"] is None else f", {point['share_new_percent']:.1f} % when new"
    return f"**{share:.1f} %** of the pump's flow at {label} ({signed(band)}{mark}{new})"


def reported(diagnosis: Diagnosis, record: dict[str, Any]) -> list[tuple[Projection, dict[str, Any]]]:
    """Return the projections that must be shown, those of the complaint first; each with its record."""
    rows = {row["name"]: row for row in record["conditions"]}
    return [(at, rows[at.condition.name]) for at in diagnosis.reported]


def listed(names: Sequence[str]) -> str:
    """Join names as a sentence does.

    >>> listed(["5", "6", "7"])
    '5, 6 and 7'
    """
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def land_rows(
    diagnosis: Diagnosis, record: dict[str, Any], lands: Iterable[LandDiagnosis], *, brief: bool = False
) -> list[dict[str, Any]]:
    """Return the rows of a table of lands, fewer columns if brief; columns without any value are left out."""
    records = {(land["component"], land["land"]): land for land in record["lands"]}
    several = len(diagnosis.projections) > 1
    rows = []
    for diagnosed in lands:
        land = records[diagnosed.key]
        worst = MatrixRow.of(diagnosed, diagnosis, diagnosis.projections).worst
        rule = None if diagnosed.verdict == Verdict.NOT_MEASURED else diagnosed.deciding
        rows.append(
            {
                "Verdict": land["verdict"],
                "Pair": pair(diagnosis.controller, *diagnosed.key),
                "Wear [%]": land["wear_percent"],
                "Share [%]": land["share_percent"],
                "Largest share [%]": _share(worst) if several else None,
                "Largest at": worst.projection.condition.label if several and worst.share > 0.0 else None,
                "Decided by": _decided_by(diagnosed, rule),
                "Clearance [µm]": land["radial_clearance_um"],
                "u [µm]": land["uncertainty_um"],
                "Over it [%]": _percent(land["probability_over_limit"]),
                "Decision": land["decision"] and land["decision"].replace("_", " "),
                "Mounting [µm]": land["mounting_clearance_um"],
                "Limit is": None if rule is None else str(rule.origin),
                "Leakage [dm³/min]": land["leakage_dm3_min"],
                "from": land["leakage_low_dm3_min"],
                "to": land["leakage_high_dm3_min"],
                "Limit at": replace_at(diagnosed, wording("en")),
            }
        )
    left_out = {"Mounting [µm]", "Limit is", "Leakage [dm³/min]", "from", "to"} if brief else set()
    names = [name for name in rows[0] if name not in left_out] if rows else []
    filled = [name for name in names if any(row[name] is not None for row in rows)]
    return [{name: row[name] for name in filled} for row in rows]


def pair(controller: Controller, component: str, land: int) -> str:
    """Return component, land and name, so that a narrow column cuts the name only: ``25 · 1 main pressure valve``."""
    return f"{component} · {land} {controller.components[component]}"


def _decided_by(land: LandDiagnosis, rule: Rule | None) -> str | None:
    """Return the rule, and which part of the pair was taken at its nominal diameter."""
    missing = {"spool_only": "sleeve", "sleeve_only": land.state.land.part_name}.get(land.state.status)
    reasons = [] if rule is None else [rule_text(rule)]
    return "; ".join([*reasons, *([f"{missing} not measured"] if missing else [])]) or None


def land_name(diagnosis: Diagnosis, key: tuple[str, int]) -> str:
    """Return a land in words: ``25 · main pressure valve, land 1``."""
    return f"{key[0]} · {diagnosis.controller.components[key[0]]}, land {key[1]}"


def advice(diagnosis: Diagnosis) -> list[str]:
    """Return what would make the open verdicts clear, one line of markdown per land."""
    return [
        f"- **component {plain(land.state.land.component)} land {land.state.land.land}**: "
        f"{plain(land.uncertainty.advice)}"
        for land in diagnosis.ranked
        if land.uncertainty is not None and land.uncertainty.advice
    ]


def _share(at: LandAtCondition) -> float | None:
    return at.share * PERCENT if math.isfinite(at.share) else None


def _percent(fraction: float | None) -> float | None:
    return None if fraction is None else fraction * PERCENT


def rule_text(rule: Rule) -> str:
    """Return a rule in words, most important first: ``share of pump flow 6.19 %, limit 4 %, hot idle``."""
    kind = rule.kind
    value = f"{rule.value * kind.factor:.3g} {kind.unit}" if math.isfinite(rule.value) else "beyond the pump"
    where = f", {rule.condition.label}" if rule.condition else ""
    return f"{rule.quantity} {value}, limit {rule.limit * kind.factor:.3g} {kind.unit}{where}"
