"""Open the own job of a fleet's unit in this session; the address names it as long as nothing of it is in the book."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import streamlit as st

from atleak.analysis.record_doubts import with_sheet
from atleak.common.errors import AtleakError, FleetError
from atleak.common.sentences import Sentence
from atleak.job.result import judged_otherwise
from atleak.report.json.diagnosis import diagnosis_record
from pages.shared import reader
from pages.shared.cases import diagnosis_of, opened_case
from pages.shared.state import OF_FLEET, InBook, Refusal, session, show_job, way_back
from pages.shared.undo import Steps, Told

if TYPE_CHECKING:
    from atleak.fleet.sources import KeptUnit


def show_unit(kept: KeptUnit, folder: str, *, done: Told | None = None) -> None:
    """Show the own job of a unit; the job book has it once it is changed.

    Parameters
    ----------
    folder
        id of the folder of results, as addresses name it.
    done
        what was done, by which the way back to the job shown before is offered; no way back unless given.

    Raises
    ------
    AtleakError
        it cannot be opened any more.
    """
    from atleak.fleet.columns import HASH

    given, record = kept.opened()
    case = opened_case(given)
    diagnosis = diagnosis_of(case)
    otherwise = judged_otherwise(kept.result, _without_circuits(diagnosis_record(diagnosis)), numbers=True)
    in_book = InBook(result_by=kept.unit["atleak"], judged_otherwise=otherwise, of_fleet=f"{folder}-{kept.unit[HASH]}")
    steps = way_back(done) if done is not None else Steps()
    show_job(case, with_sheet(record, diagnosis.readings) or record, in_book, steps)


def follow_address(open_from_book: Callable[[str], bool]) -> None:
    """Open the unit that the address names, where that is another one: after a reload, in a second tab.

    Parameters
    ----------
    open_from_book
        opens a job of the book by its id: a unit from there has no job of its own beside the book's.
    """
    wanted = st.query_params.get(OF_FLEET)
    now = session()
    if wanted is None or wanted in (now.in_book.of_fleet, now.in_book.unknown):
        return
    from atleak.fleet.units import BOOK

    try:
        kept, folder = _kept(wanted)
        reference = kept.unit["reference"]
        if not reference.startswith(BOOK):
            show_unit(kept, folder)
        elif not open_from_book(reference.removeprefix(BOOK)):
            now.in_book.unknown = wanted
    except AtleakError as error:
        now.refused["job"] = Refusal(reader.say()("fleet.of_address"), error)
        now.in_book.unknown = wanted


def _kept(wanted: str) -> tuple[KeptUnit, str]:
    from atleak.fleet.folder import known_folders
    from atleak.fleet.results import Results
    from atleak.fleet.sources import kept_unit

    id, _, sha256 = wanted.partition("-")
    folder = next((each for each in known_folders() if each.id == id), None)
    if folder is None:
        problem = Sentence("the folder of results that the address names is not known on this computer")
        raise FleetError(problem, expected=Sentence("the folder that 'atleak fleet run' was given for its results"))
    return kept_unit(Results.open(folder.path), sha256), folder.id


def _without_circuits(record: dict[str, Any]) -> dict[str, Any]:
    """Return a record without what the rows of a unit do not hold."""
    conditions = [{**each, "circuits": []} for each in record["conditions"]]
    return {**record, "conditions": conditions}
