"""Build the head of the technical annex: owner and vehicle, the verdict and the totals."""

from __future__ import annotations

from functools import cached_property
from typing import Any

from atleak.engine.profile import UNKNOWN
from atleak.engine.projection import Projection
from atleak.report.pdf.blocks import Block, PrintedColumn, grouped_table, joined
from atleak.report.pdf.conditions import Conditions
from atleak.report.pdf.printed_names import PrintedNames
from atleak.verdicts import Verdict
from atleak.views.caveats import caveat_marks, caveats
from atleak.views.first_sentence import first_sentence
from atleak.views.measured_words import measured_sentence
from atleak.views.positions import position_band
from atleak.views.pressures import lowest_first, pressures_at
from atleak.views.pump_words import pump_sentence
from atleak.views.sentences import (
    circuit_sentence,
    counted_in_speed,
    pressure_sentence,
    readings_in_doubt,
    reserve_sentence,
)
from atleak.workshop_units import DM3_MIN, KPA, PERCENT, RPM

_ROOM = 7  # conditions for whose totals the page has room


class Front:
    """What stands at the head of the annex, behind the customer's page."""

    def __init__(self, names: PrintedNames) -> None:
        self.names = names
        self.diagnosis, self.record, self.job, self.say = names.diagnosis, names.record, names.job, names.say

    def facts(self) -> list[list[str]]:
        """Return owner, vehicle and transmission; fields that were not filled in are left out."""
        job, say = self.job, self.say
        customer, vehicle, box = job.customer, job.vehicle, job.transmission
        mileage = self.names.mileage
        contact = [customer.name, customer.number, *customer.address.splitlines(), customer.phone, customer.email]
        rows = [
            ("number", job.number),
            ("date", say.date(job.date) if job.date else ""),
            ("customer", joined(contact)),
            ("vehicle", joined((vehicle.make, vehicle.model, vehicle.year), " ")),
            ("engine", vehicle.engine),
            ("registration", vehicle.registration),
            ("vin", vehicle.vin),
            ("mileage", "" if mileage is None else say("texts.mileage", value=say.value(mileage, "distance", 0))),
            ("transmission", joined((box.maker, box.code), " ")),
            ("serial", box.serial),
            ("note", box.note),
            ("technician", job.technician),
            ("complaint", job.complaint),
            ("fault_codes", joined(job.fault_codes)),
            ("controller", say.name(self.diagnosis.controller.name)),
        ]
        return [[say(f"facts.{name}"), value] for name, value in rows if value]

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
        source = [] if lowest is None else [say("findings.limits_from", source=lowest.source)]
        return [say("findings.alone"), *source]

    def _more(self) -> list[str]:
        """Return what else is to be said of the lands and the totals."""
        diagnosis, say = self.diagnosis, self.say
        at, more = diagnosis.worst, []
        tight = readings_in_doubt(diagnosis, say)
        if tight is not None:
            more.append(tight)
        speed = say.number(at.minimum_speed * RPM, 0)
        more.append(say("sentences.holds", speed=speed, counted=counted_in_speed(diagnosis, say)))
        more += self._positions(at)
        measured = pump_sentence(diagnosis, say)
        if measured is not None:
            more.append(measured)
        more += self._pressures()
        return more

    def _pressures(self) -> list[str]:
        """Return what line, pump and circuits hold where one of them is past a limit the farthest."""
        diagnosis, say, said = self.diagnosis, self.say, []
        at = pressures_at(diagnosis, lowest_first(diagnosis)[0])
        if at.projection.pressure_falls or _flagged(at.line.verdict):
            said.append(pressure_sentence(at, say))
        if _flagged(at.reserve_verdict):
            said.append(reserve_sentence(at, say))
        circuits = [circuit_sentence(diagnosis, each, say) for each in at.circuits if _flagged(each.verdict)]
        if circuits:
            named = say("texts.circuits_at", condition=self.names.condition(at.projection.condition))
            said.append(f"{named} {joined(circuits, '; ')}.")
        return said

    @cached_property
    def shown(self) -> tuple[Projection, ...]:
        """Return the conditions whose totals stand on the page: all if there is room, else those that say the most."""
        diagnosis = self.diagnosis
        if len(diagnosis.presented) <= _ROOM:
            return diagnosis.presented
        most = [*diagnosis.reported, lowest_first(diagnosis)[0]]
        return tuple(at for at in diagnosis.presented if any(at is other for other in most))

    def _totals(self) -> Block:
        say = self.say
        temperature = PrintedColumn(
            say("printed.temperature"),
            lambda at: say.plain_value(at.condition.temperature, "temperature"),
            say.unit("temperature"),
            side="r",
        )
        columns = [
            *(() if all(map(self._names_temperature, self.shown)) else (temperature,)),
            PrintedColumn(
                say("printed.speed"),
                lambda at: say.number(at.condition.engine_speed * RPM, 0),
                "1/min",
                side="r",
            ),
            PrintedColumn(say("printed.gear"), lambda at: str(at.condition.gear), side="r"),
            PrintedColumn(say("printed.pressure"), self._pressure, say.unit("pressure"), side="r"),
            PrintedColumn(
                say("printed.leakage"),
                lambda at: say.value(at.leakage * DM3_MIN, "flow", 2),
                say.unit("flow"),
                side="r",
            ),
            PrintedColumn(
                say("printed.capacity"),
                lambda at: say.value(at.pump_capacity * DM3_MIN, "flow", 2),
                say.unit("flow"),
                side="r",
            ),
            PrintedColumn(say("printed.share"), self._share, "%", side="r"),
            PrintedColumn(say("printed.share_new"), self._share_new, "%", side="r"),
            PrintedColumn(say("printed.band"), self._band, width=1),
            PrintedColumn(say("printed.reserve"), lambda at: say.number(at.reserve, 2), side="r"),
            PrintedColumn(say("printed.holds"), lambda at: say.number(at.minimum_speed * RPM, 0), "1/min", side="r"),
        ]
        return grouped_table(columns, ((self.names.condition(at.condition), [at]) for at in self.shown))

    def _names_temperature(self, at: Projection) -> bool:
        """Tell whether the name of a condition ends in its temperature."""
        temperature = self.say.plain_value(at.condition.temperature, "temperature")
        name = self.names.condition(at.condition).replace("\u00a0", " ")
        return name.endswith(f"{temperature} {self.say.unit('temperature')}")

    def _share_new(self, at: Projection) -> str:
        return self.say.number(self.diagnosis.new_at(at).share * PERCENT, 1)

    def _positions(self, at: Projection) -> list[str]:
        """Return what the total may be as the spools lie; nothing where the profile sets their position."""
        band, unknown = position_band(self.diagnosis, at), self.diagnosis.profile.eccentricity == UNKNOWN
        if band is None:
            return []
        low, high = (self.say.percent(end) for end in band)
        sentence = f"sentences.{'anywhere' if unknown else 'concentric'}"
        return [self.say(sentence, condition=self.names.condition(at.condition), low=low, high=high)]

    def _pressure(self, at: Projection) -> str:
        required = self.say.value(at.condition.main_pressure * KPA, "pressure", 0)
        held = self.say.value(at.main_pressure_held * KPA, "pressure", 0)
        return self.say("texts.held_of", required=required, held=held) if at.pressure_falls else required

    def _share(self, at: Projection) -> str:
        uncertainty = self.diagnosis.uncertainty
        total = uncertainty.total(at.condition.name) if uncertainty else None
        low, high = total.share_interval if total else (None, None)
        return self.say.number(at.share * PERCENT, 1) + self.names.interval(_percent(low), _percent(high), 1)

    def _band(self, at: Projection) -> dict[str, str] | str:
        band = self.diagnosis.band(at)
        if band is None:
            return "–"
        word = self.say.level(band)
        worst = at is self.diagnosis.worst and len(self.diagnosis.projections) > 1
        return {"sign": band.verdict, "text": self.say("texts.worst", band=word) if worst else word}


def _flagged(verdict: Verdict | None) -> bool:
    return verdict is not None and verdict.flagged


def _percent(fraction: float | None) -> float | None:
    return None if fraction is None else fraction * PERCENT
