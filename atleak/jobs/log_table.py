"""Write the channels of a road test as a Parquet table."""

from __future__ import annotations

import io

import pandas as pd

from atleak.keeping import kept_with
from atleak.road_test import RoadTest


def log_table(log: RoadTest) -> bytes:
    """Return a log's channels on its common base of time as Parquet: one column a quantity, in SI, NaN where missing.

    Temperatures are in °C and speeds in revolutions per second.
    """
    return kept_with(log, "table", "", lambda: _written(log))  # a job is saved many times with one log


def _written(log: RoadTest) -> bytes:
    columns = {quantity: log.values(quantity) for quantity in log.channels}
    target = io.BytesIO()
    pd.DataFrame({"time": log.time, **columns}).to_parquet(target, index=False, compression="zstd")
    return target.getvalue()
