"""Time reading a measuring sheet of 5000 rows into clearances, beside openpyxl loading the same workbook.

python benchmarks/readings.py [--small]
"""

from __future__ import annotations

import argparse
import io

import openpyxl
from timing import median_time, options

from atleak.catalogue.controller_file import load_controller
from atleak.measurements.clearances import clearances
from atleak.readers.sheets.measuring_sheet import read_readings

OPTIONS = options(__doc__)
ROWS = 5000
SMALL = 200


def main(chosen: argparse.Namespace) -> None:
    rows = SMALL if chosen.small else ROWS
    controller = load_controller("four_speed_2023")
    data = _workbook(rows)
    assert len(read_readings(data, controller).readings) == rows
    ours = median_time(lambda: clearances(read_readings(data, controller), controller))
    peer = median_time(lambda: list(openpyxl.load_workbook(io.BytesIO(data), data_only=True).active.values))
    print(f"{rows} rows read / openpyxl loading them   {ours / peer:.2f}   ({ours * 1e3:.0f} ms / {peer * 1e3:.0f} ms)")


def _workbook(rows: int) -> bytes:
    book = openpyxl.Workbook()
    book.active.append(["component", "part", "plane", "direction", "diameter_mm"])
    for index in range(rows):
        part, diameter = (("spool", 9.939), ("sleeve", 9.995))[index % 2]
        direction = ("0°", "90°")[index // 4 % 2]
        book.active.append([6, part, 1 + index // 2 % 2, direction, diameter + 1e-6 * (index % 7)])
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


if __name__ == "__main__":
    main(OPTIONS.parse_args())
