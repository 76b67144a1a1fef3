"""Build the head of the technical annex: owner and vehicle, the verdict and the totals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property
from typing import Any

from atleak.analysis.pressures import lowest_first, pressures_at
from atleak.catalogue.workbook.cells import gear_shown
from atleak.common.units import DM3_MIN, KPA, PERCENT, RPM
from atleak.common.verdicts import Verdict
from atleak.common.wording import begun, joined
from atleak.engine.projection import Projection
from atleak.report.pdf.blocks import Block, ends, listed, named_facts
from atleak.report.pdf.conditions import Conditions
from atleak.report.printed_names import PrintedPart
from atleak.report.tables.first_sentence import first_sentence, measured_sentence, pump_sentence
from atleak.report.tables.sentences import (
    caveat_marks,
    caveats,
    circuit_sentence,
    counted_in_speed,
    position_sentence,
    pressure_sentence,
    readings_in_doubt,
    reserve_sentence,
)
from atleak.report.tables.table import Column, Judged

_ROOM = 7  # conditions for whose totals the page has room


class Front(PrintedPart):
    """What stands at the head of the annex, behind the customer's page."""

    def facts(self) -> list[list[str]]:
        """Return owner, vehicle and transmission; fields that were not filled in are left out."""
        job, say = self.job, self.say
        customer, vehicle, box = job.customer, job.vehicle, job.transmission
        contact = [customer.name, customer.number, *customer.address.splitlines(), customer.phone, customer.email]
        block = named_facts(
            "facts",
            say,
            number=job.number,
            date=say.date(job.date) if job.date else "",
            customer=joined(contact),
            vehicle=self.names.vehicle,
            engine=vehicle.engine,
            registration=vehicle.registration,
            vin=vehicle.vin,
            mileage=self.names.mileage,
            transmission=joined((box.maker, box.code), " "),
            serial=box.serial,
            note=box.note,
            technician=job.technician,
            complaint=job.complaint,
            fault_codes=joined(job.fault_codes),
            controller=say.name(self.diagnosis.controller.name),
        )
        rows: list[list[str]] = block["rows"]
        return rows

    def verdict(self) -> dict[str, Any]:
        """Return the verdict in one sentence, and the totals below it; without a sheet what log and gauges say."""
        diagnosis, say = self.diagnosis, self.say
        alone = diagnosis.without_sheet
        marks = [f"{mark.capitalize()}." for mark in caveat_marks(diagnosis, say)]
        return {
            "key": diagnosis.verdict,
            "word": say.level(diagnosis.verdict),
            "sentence": " ".join([*marks, self._sentence()]),
            "more": " ".join([*caveats(diagnosis, say), *(self._without_sheet() if alone else self._more())]),
            "complaint": Conditions(self.names).complaint(),
            "totals": None if alone else self._totals(),
        }

    def _sentence(self) -> str:
        """Return what the verdict is and what gave it."""
        diagnosis, say = self.diagnosis, self.say
        verdict = say.level(diagnosis.verdict).capitalize()
        finding = measured_sentence(diagnosis, say)
        if finding is not None:
            by = "of_log" if diagnosis.decided_by is None else "by_pressure"
            return say(f"findings.{by}", verdict=verdict, finding=finding)
        return f"{verdict}: {first_sentence(diagnosis, say)}"

    def _without_sheet(self) -> list[str]:
        """Return that no land was measured, and where the limits of the log are from."""
        say, log = self.say, self.diagnosis.log
        permitted = log.permitted if log is not None else None
        lowest = permitted.lowest if permitted is not None else None
        source = [] if lowest is None else [say("findings.limits_from", source=say.name(lowest.source))]
        return [say("findings.alone"), *source]

    def _more(self) -> list[str]:
        """Return what else is to be said of the lands and the totals."""
        diagnosis, say, at = self.diagnosis, self.say, self.diagnosis.worst
        speed = say.number(at.minimum_speed * RPM, 0)
        said = (
            readings_in_doubt(diagnosis, say),
            say("sentences.holds", speed=speed, counted=counted_in_speed(diagnosis, say)),
            position_sentence(diagnosis, at, say),
            pump_sentence(diagnosis, say),
            *self._pressures(),
        )
        return [each for each in said if each]

    def _pressures(self) -> Iterator[str]:
        """Say what line, pump and circuits hold where one of them is past a limit the farthest."""
        diagnosis, say = self.diagnosis, self.say
        at = pressures_at(diagnosis, lowest_first(diagnosis)[0])
        if at.projection.pressure_falls or _flagged(at.line.verdict):
            yield pressure_sentence(at, say)
        if _flagged(at.reserve_verdict):
            yield reserve_sentence(at, say)
        circuits = joined(
            (circuit_sentence(diagnosis, each, say) for each in at.circuits if _flagged(each.verdict)), "; "
        )
        if circuits:
            yield f"{say('texts.circuits_at', condition=self.say.condition(at.projection.condition))} {circuits}."

    @cached_property
    def shown(self) -> tuple[Projection, ...]:
        """Return the conditions whose totals stand on the page: all if there is room, else those that say the most."""
        diagnosis = self.diagnosis
        if len(diagnosis.presented) <= _ROOM:
            return diagnosis.presented
        most = [*diagnosis.reported, lowest_first(diagnosis)[0]]
        return tuple(at for at in diagnosis.presented if any(at is other for other in most))

    def _totals(self) -> Block:
        share = Column("share", "percent", 1, times=PERCENT)
        condition = Column("condition", width=150, words=begun(self.say("printed.condition")), of=self._condition)
        columns = (
            condition,
            *([] if all(map(self._names_temperature, self.shown)) else [self._temperature]),
            self._speed("speed", lambda at: at.condition.engine_speed),
            Column("gear", digits=0, of=lambda at: gear_shown(at.condition.gear)),
            Column("pressure", "pressure", of=self._pressure),
            Column("leakage", "flow", 2, times=DM3_MIN),
            Column("capacity", "flow", 2, of="pump_capacity", times=DM3_MIN),
            share,
            *ends(self._share_interval, share),
            Column("share_new", "percent", 1, of=lambda at: self.diagnosis.new_at(at).share, times=PERCENT),
            Column("band", of=self._band),
            Column("reserve", digits=2),
            self._speed("holds", "minimum_speed"),
        )
        return {**listed(self.say, self.shown, *columns), "dense": True}

    def _condition(self, at: Projection) -> str:
        return self.say.condition(at.condition)

    def _speed(self, key: str, of: str | Callable[[Projection], float]) -> Column:
        """Return a column of engine speeds; the sentences of a report have the same unit."""
        return Column(
            key, digits=0, words=f"{self.say(f'printed.{key}')}\n{self.say.unit('engine_speed')}", of=of, times=RPM
        )

    @property
    def _temperature(self) -> Column:
        say = self.say
        return Column(
            "temperature", "temperature", of=lambda at: say.plain_value(at.condition.temperature, "temperature")
        )

    def _names_temperature(self, at: Projection) -> bool:
        """Tell whether the name of a condition ends in its temperature."""
        temperature = self.say.plain_value(at.condition.temperature, "temperature")
        name = self.say.condition(at.condition).replace("\u00a0", " ")
        return name.endswith(f"{temperature} {self.say.unit('temperature')}")

    def _pressure(self, at: Projection) -> str:
        required = self.say.value(at.condition.main_pressure * KPA, "pressure", 0)
        held = self.say.value(at.main_pressure_held * KPA, "pressure", 0)
        return self.say("texts.held_of", required=required, held=held) if at.pressure_falls else required

    def _share_interval(self, at: Projection) -> tuple[float, float] | None:
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.condition.name) if uncertainty else None
        return total.share_interval if total else None

    def _band(self, at: Projection) -> Judged:
        band = self.diagnosis.band(at)
        if band is None:
            return Judged(None)
        word = self.say.level(band)
        worst = at is self.diagnosis.worst and len(self.diagnosis.projections) > 1
        return Judged(self.say("texts.worst", band=word) if worst else word, band)


def _flagged(verdict: Verdict | None) -> bool:
    return verdict is not None and verdict.flagged
