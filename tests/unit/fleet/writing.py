"""Small rows for the tests of a fleet's results; as a program it writes units until it is ended.

It says ``ready`` before the first batch and, of every batch, the references as soon as it is written.
"""

from __future__ import annotations

import sys
from typing import Any

import pyarrow as pa

from atleak.common.verdicts import Verdict
from atleak.fleet.columns import HASH, DataSet, Rows, columns_of
from atleak.fleet.results import Results

LANDS = 3  # of every unit


def table(data_set: DataSet, *rows: dict[str, Any]) -> pa.Table:
    """Rows of a data set; every other column is null."""
    return pa.Table.from_pylist(list(rows), columns_of(data_set))


def unit(reference: str, sha256: str, evaluation: int = 1, controller: str = "four_speed_2023") -> Rows:
    """The rows of a unit, its lands and a condition; the number of the evaluation stands in all of them."""
    own = {HASH: sha256}
    lands = [{**own, "land": land, "spool_readings": evaluation} for land in range(1, LANDS + 1)]
    tables = {
        "units": table("units", {**own, "reference": reference, "name": reference, "tries": evaluation}),
        "lands": table("lands", *lands),
        "conditions": table("conditions", {**own, "name": "hot_idle", "gear": evaluation}),
    }
    return Rows(controller, sha256, reference, Verdict.OK, tables)  # type: ignore[arg-type]  # keys as texts


def failed(reference: str, sha256: str, evaluation: int = 1, controller: str | None = None) -> Rows:
    """The row of a unit that ended in an error."""
    row = {HASH: sha256, "reference": reference, "name": reference, "tries": evaluation, "kind": "refused"}
    return Rows(controller, sha256, reference, None, {"errors": table("errors", row)})


def write_until_ended(folder: str, first: str) -> None:
    """Write batches of units, of two valve bodies in turn, and tidy now and then."""
    with Results.open(folder, for_writing=True) as results:
        print("ready", flush=True)
        number = int(first)
        while True:
            results.tidy()
            for _ in range(3):
                names = [f"unit {each}" for each in range(number, number + 4)]
                bodies = ("four_speed_2023", "722")
                results.add([unit(name, f"hash of {name}", 1, bodies[at % 2]) for at, name in enumerate(names)])
                print(*names, sep=",", flush=True)
                number += 4


if __name__ == "__main__":
    write_until_ended(*sys.argv[1:])
