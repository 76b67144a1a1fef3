"""Read the road-test logs of any logger.

`read_road_test` returns the road test, or raises with what it needs; `understand` says what a file holds even while
questions are open; `describe` gives that as JSON, `tidy_csv` the road test as a plain table.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from atleak.common.errors import Place, RoadTestError
from atleak.common.sentences import Sentence
from atleak.measurements.road_test import RoadTest
from atleak.readers.logs.columns import Ambiguous
from atleak.readers.logs.importer import LogColumn, log_columns, understand
from atleak.readers.logs.parquet_log import head_of_parquet
from atleak.readers.logs.understood import FORMATS, Understood, describe, tidy_csv
from atleak.readers.remembered_columns import NOT_LOGGED, default_path, forget_columns, recall, remember, signature

__all__ = [
    "FORMATS", "NOT_LOGGED", "Ambiguous", "LogColumn", "Understood", "default_path", "describe", "forget_columns",
    "head_of_parquet", "log_columns", "read_road_test", "recall", "remember", "signature", "tidy_csv", "understand",
]  # fmt: skip


def read_road_test(
    source: str | Path | bytes,
    *,
    name: str | None = None,
    mapping: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    constants: Mapping[str, float] | None = None,
    every: int = 1,
    remembered: Path | None = None,
) -> RoadTest:
    """Read a road-test log as the logger wrote it.

    Parameters
    ----------
    source
        a path, or the file's bytes. Delimited text in any usual encoding, xlsx, Parquet, MDF4, or a gz of one of them;
        the content decides, not the extension.
    name
        what to call the file in messages; the path's own name by default.
    mapping
        quantity → column, by header text or ``column 3``; `NOT_LOGGED` where no column holds it.
    units
        quantity → unit, where the file does not state it or states it wrongly.
    constants
        quantity → value in SI [°C for temperatures] for a channel the log does not hold. For ``time``, the seconds from
        row to row of a log without a clock.
    every
        of how many rows, or of how many samples of a channel with its own clock, one is read.
    remembered
        a file of mappings chosen earlier (see `remember` and `default_path`); None: none are consulted.

    Returns
    -------
    RoadTest
        in SI, with its suspect samples marked.

    Raises
    ------
    RoadTestError
        when the file is no log, its time cannot be read, or it takes more memory than is free; says what is needed.
    """
    understood = understand(
        source, name=name, mapping=mapping, units=units, constants=constants, every=every, remembered=remembered
    )
    if understood.road_test is None:
        raise understood.problem or RoadTestError(Sentence("cannot be read"), place=Place(file=understood.file))
    return understood.road_test
