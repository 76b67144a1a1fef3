"""Read what the results of a fleet hold of one unit, whatever became of its files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from atleak.errors import FleetError, Place
from atleak.fleet.columns import HASH, DataSet
from atleak.fleet.results import Results
from atleak.fleet.sources import reopened
from atleak.job.case import Case
from atleak.job.record import Job
from atleak.sentence import Sentence
from atleak.verdicts import Verdict

_OF_LANDS = (
    *("component", "land", "measured", "verdict", "decision"),
    *("radial_clearance_um", "uncertainty_um", "wear_percent", "leakage_dm3_min", "share_percent"),
)
_OF_CONDITIONS = (
    *("name", "label", "temperature_c", "engine_rpm", "gear", "band", "decision"),
    *("leakage_dm3_min", "share_percent", "p_g_kpa", "p_g_held_kpa", "reserve"),
)
Row = Mapping[str, Any]  # a value, or None, by the name of its column


@dataclass(frozen=True)
class KeptUnit:
    """The row of a unit, and of its lands, the worst first, and its conditions what people ask for first."""

    unit: Row
    lands: tuple[Row, ...]
    conditions: tuple[Row, ...]

    @property
    def result(self) -> Row:
        """Return what the rows say as `atleak.job.judged_anew.judged_otherwise` takes it; of circuits nothing."""
        unit = {"decision": self.unit["decision"]}
        return {
            "verdict": self.unit["verdict"],
            "unit": unit,
            "lands": list(self.lands),
            "conditions": list(self.conditions),
        }

    def opened(self) -> tuple[Case, Job]:
        """Return the case and the record of the job that the rows are the result of.

        Raises
        ------
        AtleakError
            its files are not there any more, cannot be read, or are others than the result rests on.
        """
        return reopened(self.unit["reference"], choices=self.unit["choices"] or "", input_sha256=self.unit[HASH])


def kept_unit(results: Results, sha256: str) -> KeptUnit:
    """Read the rows of a unit.

    Parameters
    ----------
    results
        open for reading.
    sha256
        the hash of all that its result rests on.

    Raises
    ------
    FleetError
        the results hold no such unit; a part of them that is damaged.
    """

    def rows(data_set: DataSet, columns: Sequence[str] | None = None) -> tuple[Row, ...]:
        return tuple(results.table(data_set, columns, hashes={sha256}).to_pylist())

    found = rows("units")
    if not found:
        raise FleetError(Sentence("holds no result of this unit any more"), place=Place(file=str(results.folder)))
    ranks = {str(verdict): verdict.rank for verdict in Verdict}
    lands = sorted(rows("lands", _OF_LANDS), key=lambda land: -ranks.get(land["verdict"], 0))
    return KeptUnit(found[0], tuple(lands), rows("conditions", _OF_CONDITIONS))
