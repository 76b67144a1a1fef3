"""Sum up a fleet from its data sets: verdicts, wear over mileage, the worst pairs, temperatures, groups, errors."""

from __future__ import annotations

from typing import Protocol

import pyarrow as pa

from atleak.fleet.summed import LISTED, FleetSummary


class DataSets(Protocol):
    """The data sets of a fleet's results, as `atleak.fleet.results.Results` reads them."""

    def table(self, data_set: str, columns: list[str] | None = None, controllers: list[str] | None = None) -> pa.Table:
        """Return some columns of a data set, one row for each that counts."""

    def controllers(self) -> tuple[str, ...]:
        """Return the ids of all valve bodies that have a unit."""


def summed_up(
    results: DataSets, *, by: str | None = None, controller: str | None = None, listed: int = LISTED
) -> FleetSummary:
    """Sum up the results of a fleet.

    Parameters
    ----------
    results
        open for reading.
    by
        heading of a label, or ``group``, whose values are compared.
    controller
        id of the only valve body to be summed up; all of them unless given.
    listed
        how many units are listed, the worst first.

    Raises
    ------
    InputError
        No unit states such a heading, or none is of such a valve body.
    """
    raise NotImplementedError
