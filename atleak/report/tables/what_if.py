"""Show a unit as it is tried as rows: totals and pressures beside those of the job."""

from __future__ import annotations

from atleak.analysis.what_if import Tried
from atleak.catalogue.limits import RuleKind
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM, gear_name
from atleak.common.verdicts import Band, Verdict
from atleak.common.wording import Wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.engine.projection import CircuitState, Projection
from atleak.report.tables.table import VERDICT, Column, Table


def condition_words(projection: Projection, say: Wording) -> str:
    """Say a condition in the reader's words and units: temperature, engine speed, gear."""
    at = projection.condition
    temperature = say.plain_quantity(at.temperature, "temperature")
    speed = say.quantity(at.engine_speed * RPM, "engine_speed")
    return say("what_if.condition", temperature=temperature, speed=speed, gear=gear_name(at.gear))


def tried_words(tried: Tried, say: Wording) -> str:
    """Say everything that is tried: the condition, and in what else it departs from the job."""
    at, parts = tried.settings, [condition_words(tried.projection, say)]
    if at.wear != 1.0:
        parts.append(say("what_if.with_wear", factor=say.plain(at.wear)))
    if at.growth:
        parts.append(say("what_if.with_growth", growth=say.percent(at.growth, 0)))
    if at.fluid is not None:
        parts.append(say.name(at.fluid.name))
    if at.fluid_state is not None:
        parts.append(say("what_if.with_fluid", state=say(f"what_if.{at.fluid_state}")))
    if at.eccentricity is not None:
        unknown = isinstance(at.eccentricity, str)
        parts.append(say("what_if.position_unknown") if unknown else f"e/c {say.plain(float(at.eccentricity))}")
    return ", ".join(parts)


def tried_total_table(diagnosis: Diagnosis, tried: Tried, say: Wording) -> Table:
    """Return a row for the job and one for what is tried; nothing is judged of a unit that nobody measured."""

    def band(at: Projection) -> Verdict | Band | None:
        if not diagnosis.judged:
            return None
        return diagnosis.total_rule(at).level if at is tried.job else tried.total.level

    columns = (
        Column("verdict", VERDICT, width=92, of=band),
        Column("what_if", of=lambda at: say(f"what_if.{'the_job' if at is tried.job else 'tried'}")),
        Column(
            "tried_at",
            width=300,
            of=lambda at: condition_words(at, say) if at is tried.job else tried_words(tried, say),
        ),
        Column("share", "percent", 1, times=PERCENT),
        Column("leakage", "flow", times=DM3_MIN),
        Column("reserve", digits=2),
        Column("required", "pressure", of=lambda at: at.condition.main_pressure, times=KPA),
        Column("line_held", "pressure", of="main_pressure_held", times=KPA),
    )
    return Table("totals", columns, (tried.job, tried.projection), say)


def tried_circuit_table(diagnosis: Diagnosis, tried: Tried, say: Wording) -> Table:
    """Return a row for every circuit that is applied as it is tried; none where no pressure is solved."""
    rules = {
        rule.circuit.id: rule
        for rule in tried.pressures
        if rule.circuit is not None and rule.kind is RuleKind.CIRCUIT_LOSS
    }

    def verdict(state: CircuitState) -> Verdict | None:
        return diagnosis.verdict_on(rules.get(state.circuit.id)) if diagnosis.judged else None

    def in_job(state: CircuitState) -> float | None:
        job = tried.job.circuit(state.circuit.id)
        return None if job.vented else job.pressure

    def when_new(state: CircuitState) -> float | None:
        rule = rules.get(state.circuit.id)
        return None if rule is None else rule.new

    columns = (
        Column("verdict", VERDICT, width=92, of=verdict),
        Column("circuit", width=190, of=lambda state: say.name(state.circuit.name)),
        Column("job_held", "pressure", of=in_job, times=KPA),
        Column("tried_held", "pressure", of="pressure", times=KPA),
        Column("new_held", "pressure", of=when_new, times=KPA),
        Column("set_pressure", "pressure", times=KPA),
    )
    solved = diagnosis.profile.circuits == "on"
    applied = [state for state in tried.projection.circuits if solved and not state.vented]
    return Table("circuits", columns, applied, say)
