"""Run one unit as a task of dask's: a worker calls this, and what it gives back travels as bytes."""

from __future__ import annotations

import pickle
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import pyarrow as pa
from distributed import get_worker

from atleak.fleet.columns import DataSet, ErrorKind, columns_of
from atleak.fleet.rows import Rows
from atleak.fleet.units import FleetUnit
from atleak.fleet.watchdog import ended_after
from atleak.fleet.work import Room, evaluate
from atleak.verdicts import Verdict
from atleak.version import __version__

OVERDUE = "atleak-fleet-overdue"  # topic of the scheduler's event log: whose time limit was exceeded
BEGUN = "atleak-fleet-begun"  # likewise: which unit is begun now, of those that are tried alone
_OUT = 0.5  # [s] for what is told to get out: a unit may hold the interpreter at once


class OtherVersionError(Exception):
    """A worker has another version of atleak than the one that sent it a unit."""


@dataclass(frozen=True)
class Packed:
    """The rows of one unit as they travel: tables as Arrow's own bytes, without columns, which both sides know."""

    controller: str | None
    input_sha256: str
    reference: str
    verdict: Verdict | None
    error: ErrorKind | None
    tables: Mapping[DataSet, bytes]

    @classmethod
    def of(cls, rows: Rows) -> Packed:
        """Pack the rows of a unit."""
        errors = rows.tables.get("errors")
        kind = None if errors is None else cast(ErrorKind, errors.column("kind")[0].as_py())
        tables = {data_set: _written(table) for data_set, table in rows.tables.items()}
        return cls(rows.controller, rows.input_sha256, rows.reference, rows.verdict, kind, tables)

    @property
    def rows(self) -> Rows:
        """Return the rows as they were."""
        tables = {data_set: _read(content, data_set) for data_set, content in self.tables.items()}
        return Rows(self.controller, self.input_sha256, self.reference, self.verdict, tables)


def packed_unit(unit: FleetUnit) -> bytes:
    """Return a unit as it travels to a worker; dask then need not look for anything of its own in it."""
    return pickle.dumps(unit, protocol=pickle.HIGHEST_PROTOCOL)


def on_worker(
    unit: bytes, name: str, tries: int, time_limit: float | None, version: str, *, tell_begun: bool = False
) -> Packed:
    """Evaluate a unit within its time.

    Parameters
    ----------
    unit
        as `packed_unit` gives it.
    name
        of this try, by which the scheduler's event log is to know it.
    tries
        how often the unit was begun, this time with it.
    time_limit
        [s] after which this process ends; None: never.
    version
        of the atleak that sends the unit.
    tell_begun
        whether the scheduler's event log is told when the unit's time begins.

    Raises
    ------
    OtherVersionError
        this worker has another one, by which the results would not be what the run says they are.
    """
    if version != __version__:
        raise OtherVersionError(__version__)
    worker = get_worker()
    if tell_begun:
        worker.log_event(BEGUN, {"name": name})
        time.sleep(_OUT)
    with ended_after(time_limit, lambda: worker.log_event(OVERDUE, {"name": name, "worker": worker.address})):
        room = Room(worker.memory_manager.memory_limit or None, Path(worker.local_directory))
        return Packed.of(evaluate(pickle.loads(unit), tries=tries, room=room))


def _written(table: pa.Table) -> bytes:
    (batch,) = table.combine_chunks().to_batches()
    return batch.serialize().to_pybytes()


def _read(content: bytes, data_set: DataSet) -> pa.Table:
    return pa.Table.from_batches([pa.ipc.read_record_batch(pa.py_buffer(content), columns_of(data_set))])
