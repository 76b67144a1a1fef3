"""Show fields for gauge readings, flows and a vacuum test. What is typed lives in a file of the job, sign for sign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any, ClassVar

import streamlit as st

from atleak.catalogue.controller import Controller
from atleak.catalogue.written_numbers import ENGINE_SPEED, TEMPERATURE, AskedNumber, read_number
from atleak.common.errors import InputError
from atleak.common.file_faults import faults_together
from atleak.common.sentences import Sentence
from atleak.common.units import unit
from atleak.diagnosis.vacuum_stand import flow_of_reading
from atleak.job.case import SourceFile
from atleak.measurements.flow_readings import COOLER, consumer_of
from atleak.measurements.gauge_readings import Engine, GaugeCell, ranges_of, tap_name, taps_of
from atleak.measurements.vacuum import VacuumTable
from atleak.readers.gauges.gauge_table import asked_pressure, read_pressure_table
from atleak.readers.gauges.typed_values import TYPED_GAUGES_FILE, Part, TypedFlows, TypedGauges, TypedTable, TypedVacuum
from atleak.readers.gauges.vacuum_table import read_vacuum_table
from atleak.readers.gauges.value_table import read_flow_table
from atleak.report.tables.names import component_words, land_words
from pages.shared import fields, reader, show
from pages.shared.cases import controller_of
from pages.shared.state import put_file, session

Rows = Sequence[Sequence[tuple[Part, str]]]  # cells beside one another, each with its label
_BESIDE = 4  # fields in a line


class TypedForm:
    """Fields whose texts are a file of the job; the file's own reader says what of them cannot be used."""

    words: ClassVar[str]  # table of the texts
    at: ClassVar[str]  # what is asked for the group of cells
    slot: ClassVar[str]  # of the job
    file: ClassVar[str]  # name of the file
    kind: ClassVar[type[TypedTable]]
    read: ClassVar[Callable[..., object]]
    units: ClassVar[Sequence[str]]
    quantity: ClassVar[str]  # of the cells
    beside: ClassVar[Mapping[str, str]] = {}  # fields beside the cells, with their units; "" for that of the cells

    def __init__(self, controller: Controller) -> None:
        self.controller, self.say = controller, reader.say()
        self._key = f"{self.slot}{session().generation}-{controller.sha256[:12]}"

    @property
    def fresh(self) -> TypedTable:
        """Return the form with nothing typed, in the reader's unit where it is one of the form's."""
        usual = self.say.unit(self.quantity)
        return self.kind(unit=usual if usual in self.units else self.units[0])

    @property
    def groups(self) -> Mapping[str, str]:
        """Return the names of the groups of cells."""
        raise NotImplementedError

    def rows(self, group: str) -> Rows:
        """Return the cells of a group."""
        raise NotImplementedError

    def asked(self, part: Part, shown: str) -> AskedNumber:
        """Return the number that a field asks for."""
        return AskedNumber(Sentence("value"), shown)

    @property
    def pending(self) -> SourceFile | None:
        """Return the file to show: the one refused last, else that of the job."""
        refused = session().refused.get(self.slot)
        file: SourceFile | None = refused.file if refused is not None else getattr(session().case, self.slot)
        return file

    def draw(self) -> None:
        """Draw the fields, or say that the values come from a file."""
        file, say = self.pending, self.say
        if file is not None and self.kind.read(file.content) is None:
            st.caption(say("typed_form.read_from", file=show.plain(file.name)))
            return
        typed, last = self._typed, self._counted
        _, faults = self._judged(typed)
        places = [place for _ in range(0, len(self.beside) + 2, _BESIDE) for place in st.columns(_BESIDE)]
        first, key = self.units.index(typed.unit) if typed.unit in self.units else 0, f"{self._key}-unit"
        places[0].selectbox(say("typed_form.unit"), self.units, first, key=key, on_change=self._put, args=("unit", key))
        for place, (name, shown) in zip(places[1:], self.beside.items(), strict=False):
            with place:
                self._field(name, say(f"{self.words}.{name}"), shown or typed.unit, typed, last, faults)
        group = fields.one_of(say(self.at), self.groups, f"{self._key}-group", place=places[len(self.beside) + 1])
        for row in self.rows(group):
            for place, (cell, label) in zip(st.columns(len(row)), row, strict=True):
                with place:
                    self._field(cell, label, typed.unit, typed, last, faults)

    def _field(
        self, part: Part, label: str, shown: str, typed: TypedTable, last: TypedTable, faults: Mapping[Part, InputError]
    ) -> None:
        text, key, shown = typed.text(part), f"{self._key}-{part}", self.say.get("units", shown)
        st.text_input(f"{label} [{shown}]", text, key=key, on_change=self._put, args=(part, key))
        with st.container():
            if part in faults:
                asked, error = self.asked(part, shown), faults[part]
                why = InputError(error.problem, expected=error.expected).sentence
                doubt = read_number(text, asked).doubt or Sentence("{reason}.", reason=why)
                fields.fault(doubt, asked.name, f"{last.text(part)} {shown}" if last.text(part) else "")

    @property
    def _counted(self) -> TypedTable:
        """Return what of the typed values is in the job."""
        file = self.pending
        return (None if file is None else self.kind.read(file.content)) or self.fresh

    @property
    def _in_job(self) -> tuple[int, str | None]:
        """Return what tells the job's values from others."""
        file = self.pending
        return session().generation, None if file is None else file.sha256

    @property
    def _typed(self) -> TypedTable:
        """Return what was typed so far, with what does not count."""
        of, typed = st.session_state.get(f"typed-{self.slot}", (None, None))
        return typed if typed is not None and of == self._in_job else self._counted

    def _faults(self, typed: TypedTable) -> Mapping[Part, InputError]:
        """Return what cannot be read, by where it stands; of the fields beside the cells even without one."""
        cells = typed.cells or {self.rows(next(iter(self.groups)))[0][0][0]: "1"}
        judged = replace(typed, cells=cells)
        try:
            type(self).read(judged.written() or b"", controller_of(session().case), name=self.file)
        except InputError as error:
            found = {judged.part_at(each.place): each for each in reversed((error, *error.others))}
            return {part: each for part, each in found.items() if isinstance(part, str) or part in typed.cells}
        return {}

    def _judged(self, typed: TypedTable) -> tuple[TypedTable, Mapping[Part, InputError]]:
        """Return what counts of what was typed, and why the rest does not: of that the last text that did counts."""
        last, counting, found = self._counted, typed, dict[Part, InputError]()
        while faults := self._faults(counting):
            before, found = counting, {**faults, **found}
            for fault in faults:
                of_unit = isinstance(fault, str) or last.unit == typed.unit
                counting = counting.with_text(fault, last.text(fault) if of_unit else "")
            if counting == before:
                break
        return counting, found

    def _put(self, part: Part, key: str) -> None:
        """Put what was typed into the job; what cannot be read waits at its field, and the value before it stays."""
        typed = self._typed.with_text(part, st.session_state[key].strip())
        counting, _ = self._judged(typed)
        content = counting.written()
        if content is None:
            session().refused.pop(self.slot, None)
        if content is not None or getattr(session().case, self.slot) is not None:
            put_file(self.slot, None if content is None else SourceFile(self.file, content))
        st.session_state[f"typed-{self.slot}"] = (self._in_job, typed)


class GaugeForm(TypedForm):
    """Gauge readings of the standing vehicle."""

    words, at, slot, file = "gauge_page", "gauge_page.at", "pressures", TYPED_GAUGES_FILE
    kind, read, quantity = TypedGauges, read_pressure_table, "pressure"
    units = ("kPa", "bar", "psi", "MPa")
    beside: ClassVar[Mapping[str, str]] = {"temperature": "°C", "fast_idle": "rpm"}

    @property
    def groups(self) -> Mapping[str, str]:
        return {tap: self.say.sentence(tap_name(self.controller, tap)) for tap in taps_of(self.controller)}

    def rows(self, group: str) -> Rows:
        def cell(selected: Any, engine: Engine) -> tuple[Part, str]:
            label = self.say("gauge_page.cell", range=selected, engine=self.say.sentence(engine.label))
            return GaugeCell(selected, engine, group), label

        return [[cell(selected, engine) for engine in Engine] for selected in ranges_of(self.controller)]

    def asked(self, part: Part, shown: str) -> AskedNumber:
        if isinstance(part, str):
            return {"temperature": TEMPERATURE, "fast_idle": ENGINE_SPEED}[part]
        return asked_pressure(unit(shown, "pressure"))


class FlowForm(TypedForm):
    """Flows caught in a jug."""

    words, at, slot, file = "jug_page", "jug_page.at", "flows", "typed flows.csv"
    kind, read, quantity = TypedFlows, read_flow_table, "flow"
    units = ("l/min", "ml/15 s", "qt in 20 s", "gpm")

    @property
    def groups(self) -> Mapping[str, str]:
        points = sorted(self.controller.operating_points, key=lambda each: each.name != "hot_idle")
        return {each.name: self.say.condition(each) for each in points}

    def rows(self, group: str) -> Rows:
        cooler = consumer_of(self.controller, COOLER)
        others = [each for each in self.controller.consumers if each != cooler]
        cells = [((group, COOLER), self.say("jug_page.cooler"))]
        cells += [((group, each.id), self.say.name(each.name)) for each in others]
        return [cells[start : start + 3] for start in range(0, len(cells), 3)]


def _read_vacuum(content: bytes, controller: Controller, *, name: str) -> VacuumTable:
    """Read a vacuum test; a reading for which the stand is not known yet is a fault of it."""
    table, faults = read_vacuum_table(content, controller, name=name), []
    for reading in table.readings:
        try:
            flow_of_reading(table, reading)
        except InputError as error:
            faults.append(error)
    if faults:
        raise faults_together(faults)
    return table


class VacuumForm(TypedForm):
    """A vacuum test of plugged circuits and lands, and the stand that was read."""

    words, at, slot, file = "vacuum_page", "vacuum_page.at", "vacuum", "typed vacuum test.csv"
    kind, read, quantity = TypedVacuum, _read_vacuum, "vacuum"
    units = ("in-Hg", "kPa", "mbar", "mmHg")
    beside: ClassVar[Mapping[str, str]] = {
        "supply": "",
        "ambient": "kPa",
        "temperature": "°C",
        "known_1": "mm",
        "shown_1": "",
        "known_2": "mm",
        "shown_2": "",
        "orifice": "mm",
    }

    @property
    def groups(self) -> Mapping[str, str]:
        circuits = {"": self.say("vacuum_page.circuits")} if self._circuits else {}
        components = dict.fromkeys(land.component for land in self.controller.lands)
        return circuits | {each: component_words(self.controller, each, self.say) for each in components}

    @property
    def _circuits(self) -> Mapping[str, str]:
        leaking = {gap.section for gap in self.controller.gaps}
        return {each.id: self.say.name(each.name) for each in self.controller.circuits if each.id in leaking}

    def rows(self, group: str) -> Rows:
        keys = [land.key for land in self.controller.lands if land.component == group]
        lands = {f"{key[0]}/{key[1]}": land_words(self.controller, key, self.say) for key in keys}
        names = lands if group else self._circuits
        return [
            [((target, state), f"{name}, {self.say(f'vacuum_page.{state}')}") for state in ("worn", "repaired")]
            for target, name in names.items()
        ]
