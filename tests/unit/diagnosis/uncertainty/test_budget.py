"""The budget of a clearance, row by row: it comes to the same uncertainty as everything else is computed with."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from atleak.catalogue.instruments import load_instruments
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.uncertainty import Assumptions
from atleak.diagnosis.uncertainty.results import BudgetLine, budget_lines, combined, effective_degrees, every_line
from atleak.diagnosis.uncertainty.sources import LandSources, find_sources
from atleak.measurements.clearances import clearances


def sources_of(worn: Diagnosis, spool: str, sleeve: str, assumptions: Assumptions) -> tuple[LandSources, ...]:
    instruments = load_instruments(spool, sleeve)
    states = clearances(worn.readings, worn.controller, instruments=instruments)
    return find_sources(states, worn.readings, worn.controller, instruments, assumptions)[0]


def lines_of(land: LandSources) -> dict[tuple[str, str | None], BudgetLine]:
    return {(line.source.kind, line.source.part): line for line in budget_lines(land)}


@pytest.mark.parametrize(
    ("spool", "sleeve"),
    [("workshop_microscope", "bore_gauge"), ("air_gauge", "air_gauge"), ("micrometer", "bore_gauge")],
)
def test_the_rows_come_to_the_combined_uncertainty(worn: Diagnosis, spool: str, sleeve: str) -> None:
    for land in sources_of(worn, spool, sleeve, Assumptions(room_temperature=4.0)):
        lines = budget_lines(land)
        assert lines
        assert combined(lines) == pytest.approx(land.standard_uncertainty, rel=1e-12, abs=0.0)
        assert math.fsum(line.fraction for line in lines) == pytest.approx(1.0, abs=1e-12)
        for line in lines:
            assert line.contribution == pytest.approx(line.sensitivity * line.input_uncertainty, rel=1e-12, abs=1e-18)
        parts = [abs(line.contribution) for line in lines]
        assert parts == sorted(parts, reverse=True)


def test_the_clearance_takes_half_of_what_is_uncertain_in_a_diameter(worn: Diagnosis) -> None:
    instruments = load_instruments("micrometer", "bore_gauge")
    for land in sources_of(worn, "micrometer", "bore_gauge", Assumptions()):
        lines = lines_of(land)
        for (kind, part), line in lines.items():
            if line.input_kind == "diameter":
                assert abs(line.sensitivity) == pytest.approx(0.5, abs=1e-12), (kind, part)
        if ("common calibration", "sleeve") in lines:
            line = lines["common calibration", "sleeve"]
            assert line.input_uncertainty == pytest.approx(instruments.sleeve.common, abs=0.0)
            assert (line.sensitivity, lines["common calibration", "spool"].sensitivity) == pytest.approx(
                (0.5, -0.5), abs=1e-12
            )


def test_the_sensitivity_to_temperature_is_what_correcting_by_it_does(worn: Diagnosis) -> None:
    lands = sources_of(worn, "micrometer", "bore_gauge", Assumptions(room_temperature=2.0))
    instruments = load_instruments("micrometer", "bore_gauge")
    cold, warm = (
        clearances(worn.readings, worn.controller, temperature_c=at, instruments=instruments) for at in (19.5, 20.5)
    )
    for land, before, after in zip(lands, cold, warm, strict=True):
        if land.state.status == "measured":
            (line,) = (each for each in budget_lines(land) if each.input_kind == "temperature")
            assert line.input_uncertainty == pytest.approx(2.0 / math.sqrt(3.0), abs=1e-12)
            change = after.radial_clearance - before.radial_clearance
            assert abs(line.sensitivity) == pytest.approx(abs(change), rel=1e-3, abs=0.0)


def test_the_common_error_of_one_gauge_for_both_parts_drops_out(worn: Diagnosis) -> None:
    lands = sources_of(worn, "air_gauge", "air_gauge", Assumptions())
    alike = lands[0].instruments.err_alike
    line = lines_of(lands[0])["common calibration", None if alike else "sleeve"]
    assert (line.input_uncertainty > 0.0, line.contribution == 0.0) == (True, alike)


def test_only_repeats_of_this_unit_have_degrees_of_freedom(worn: Diagnosis) -> None:
    land = sources_of(worn, "micrometer", "bore_gauge", Assumptions())[0]
    for line in budget_lines(land):
        spread = land.spreads["sleeve" if line.source.part is None else line.source.part]
        of_repeats = line.source.kind == "repeats" and spread.origin == "repeats"
        assert line.statistical is of_repeats
        assert line.degrees_of_freedom == (spread.degrees_of_freedom if of_repeats else math.inf)
    told = replace(land.spreads["sleeve"], origin="instrument")
    by_gauge = replace(land, spreads={**land.spreads, "sleeve": told})
    assert not lines_of(by_gauge)["repeats", "sleeve"].statistical


def test_effective_degrees_of_freedom_are_those_of_repeats_alone_where_nothing_else_counts(worn: Diagnosis) -> None:
    land = sources_of(worn, "air_gauge", "air_gauge", Assumptions())[0]
    lines = every_line(land)
    assert {line.source for line in budget_lines(land)} <= {line.source for line in lines}
    repeats = [line for line in lines if line.statistical]
    alone = [replace(repeats[0], degrees_of_freedom=7.0)]
    assert effective_degrees(alone) == pytest.approx(7.0, rel=1e-12, abs=0.0)
    assert effective_degrees([replace(repeats[0], degrees_of_freedom=math.inf)]) == math.inf
    assert effective_degrees(lines) > effective_degrees(repeats) >= min(line.degrees_of_freedom for line in repeats)
