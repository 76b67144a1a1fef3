"""Doubt what a job record says beside a result: unknown parts, other instruments, another unit's sheet."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from atleak.catalogue.instruments import Instrument, Part
from atleak.diagnosis import Diagnosis
from atleak.errors import InputError, Message, Place, unknown
from atleak.job.decisions import covered, decision_faults
from atleak.job.of_sheet import sheet_doubts
from atleak.job.record import InstrumentUsed, Job, RepairDecision
from atleak.sentence import Name, Sentence
from atleak.views.pressures import behind_limits
from atleak.wording import languages, wording

_WORD = re.compile(r"[^\W\d_]{3,}")  # neither a size nor a serial number tells instruments apart
_PARTS: Mapping[Part, Sentence] = MappingProxyType({"spool": Sentence("spools"), "sleeve": Sentence("sleeves")})


def record_doubts(job: Job, diagnosis: Diagnosis) -> tuple[Message, ...]:
    """Return what is doubtful about a record, each a warning: nothing of it changes the result."""
    return (
        *_unknown_parts(job, diagnosis),
        *_other_instruments(job, diagnosis),
        *_needless(job, diagnosis),
        *sheet_doubts(job, diagnosis.readings, diagnosis.mileage),
    )


def _unknown_parts(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    """Doubt decisions, scratches and photos of parts that the valve body does not have, with the nearest name."""
    controller = diagnosis.controller
    for each in decision_faults(job, controller):
        yield Message("warning", "record_unknown_part", each.sentence)
    stated = {
        "scratches": [each.component for each in job.scratches],
        "photos": [each.component for each in job.photos],
    }
    for table, components in stated.items():
        for number, component in enumerate(components, start=1):
            if component and component not in controller.components:
                place = Place(file="job record", table=f"{table} {number}")
                problem = Sentence("{controller} has no such component", controller=Name(controller.name))
                fault: InputError = unknown(problem, component, controller.components, place=place)
                yield Message("warning", "record_unknown_part", fault.sentence)


def needless_work(job: Job, diagnosis: Diagnosis) -> Iterator[RepairDecision]:
    """Return the work still to be done on lands of which none is past a limit, nor behind one that is passed."""
    asked = behind_limits(diagnosis)
    for each in job.repair_decisions if diagnosis.judged else ():
        keys = covered(each, diagnosis.controller)
        if each.decision in ("proposed", "approved") and keys and not keys & asked:
            yield each


def _needless(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    for each in needless_work(job, diagnosis):
        keys = sorted(covered(each, diagnosis.controller))
        text = Sentence(
            "{component} ({lands}): work is decided here that no limit asks for. None of these lands is past a limit, "
            "nor behind a total or pressure that is.",
            component=Name(diagnosis.controller.components[keys[0][0]]),
            lands=[f"{component}/{land}" for component, land in keys],
        )
        yield Message("warning", "work_without_need", text)


def _other_instruments(job: Job, diagnosis: Diagnosis) -> Iterator[Message]:
    """Doubt that the instruments of the record are those by which the uncertainty was computed."""
    used = tuple(each for each in job.instruments if each.name)
    uncertainty = diagnosis.uncertainty
    if not used or uncertainty is None:
        return
    taken = [uncertainty.instruments.of(part) for part in _PARTS]
    if all(any(_alike(each, instrument) for instrument in taken) for each in used):
        return  # one is named, and it is one of the two
    for (part, what), instrument in zip(_PARTS.items(), taken, strict=True):
        if not any(_alike(each, instrument) for each in used):
            text = Sentence(
                "Measured with {used}, as the job's record or the measuring sheet's head says, but the uncertainty "
                "of the {parts} is computed with {taken}: choose the instrument with which they were measured (page "
                "Settings, --{part}-instrument), or correct its name.",
                used=tuple(each.name for each in used),
                parts=what,
                taken=Name(instrument.name),
                part=part,
            )
            yield Message("warning", "instruments_differ", text)


def _alike(used: InstrumentUsed, taken: Instrument) -> bool:
    """Tell whether a name of the record can be an instrument's in any language: one has all words of the other."""
    mine = _words(used.name)
    names = (taken.id, taken.name, *(wording(language).name(taken.name) for language in languages()))
    return any(mine <= words or words <= mine for words in map(_words, names) if words and mine)


def _words(name: str) -> frozenset[str]:
    return frozenset(word.casefold() for word in _WORD.findall(name.replace("_", " ")))
