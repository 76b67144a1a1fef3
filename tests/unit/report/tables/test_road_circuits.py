"""What a log's record says of the circuits."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import Limits
from atleak.common.wording import wording
from atleak.diagnosis.examination import diagnose
from atleak.readers.logs import read_road_test
from atleak.report.tables.road_record import road_record
from atleak.report.tables.road_test import circuit_table


def test_the_record_has_what_each_circuit_holds_and_where_it_is_lowest(
    sample_log: Path, hipol: Fluid, limits: Limits
) -> None:
    five_speed = load_controller("five_speed_2005")
    log = read_road_test(sample_log)
    diagnosis = diagnose(five_speed, hipol, limits, road_test=log)
    road, record = diagnosis.road, road_record(diagnosis)
    assert road is not None
    assert record is not None
    by_id = {each["id"]: each for each in record["circuits"]}
    assert "forward_clutch" in by_id
    for name, each in by_id.items():
        applied = np.isin(log.values("gear"), list(road.circuit_ranges[name].circuit.gears))
        assert each["lowest_kpa"] * 1e3 == pytest.approx(np.nanmin(road.circuits[name][applied]), rel=1e-12, abs=0.0)
        assert each["lowest_kpa"] <= each["p_g_there_kpa"]
    assert [row["circuit"] for row in circuit_table(road, wording("en")).records()] == [
        each["name"] for each in record["circuits"]
    ]
    without = diagnose(replace(five_speed, circuits=(), line=None, leaks=(), gaps=()), hipol, limits, road_test=log)
    record = road_record(without)
    assert record is not None
    assert record["circuits"] == []
