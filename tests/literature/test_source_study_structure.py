"""Second gear of the shipped controller against the article's equations (16) to (26)."""

from __future__ import annotations

import pytest

from atleak.catalogue.controller import Controller, Gap

SECTIONS = {
    "eq16-p_g": ("p_g", {"5", "7", "8", "9", "11", "14", "15", "16", "17", "20", "23", "25", "26"}),
    "eq20-p_s": ("p_s", {"13", "14", "15", "16", "17", "18", "19"}),
    "eq22-p_m": ("p_m", {"7", "8", "12", "12'"}),
    "eq25-p_k": ("p_k", {"20", "22", "23"}),
}
#: equation → (section, component, land, from, to)
PRINTED_GAPS = {
    "eq17-5": [("p_g", "5", 1, "p_g", "p_m")],
    "eq18-8": [("p_g", "8", 1, "p_g", "p_m"), ("p_g", "8", 2, "p_g", "0.1*p_g")],
    "eq19-26": [("p_g", "26", land, "p_g", "0.5*p_g") for land in (1, 2, 3, 4)],
    "eq21-13": [("p_s", "13", 1, "p_s", "0.1*p_g")],
    "eq23-7": [("p_m", "7", 1, "p_m", "0.1*p_m")],
    "eq24-8": [("p_m", "8", 1, "p_m", "0.1*p_m")],
    "eq26-20": [("p_k", "20", 1, "p_k", "drain"), ("p_k", "20", 2, "p_k", "0.1*p_k")],
}


def written(gap: Gap) -> tuple[str, str, int, str, str]:
    return gap.section, gap.component, gap.land, str(gap.high), str(gap.low)


@pytest.mark.parametrize(("section", "components"), SECTIONS.values(), ids=SECTIONS)
def test_components_of_a_section_in_second_gear(section: str, components: set[str], four_speed: Controller) -> None:
    assert {gap.component for gap in four_speed.gaps_in(2) if gap.section == section} == components


@pytest.mark.parametrize("printed", PRINTED_GAPS.values(), ids=PRINTED_GAPS)
def test_printed_gaps_of_a_component_and_section(printed: list[tuple], four_speed: Controller) -> None:
    section, component = printed[0][:2]
    held = [
        gap for gap in four_speed.gaps_in(2) if (gap.section, gap.component) == (section, component) and gap.published
    ]
    assert [written(gap) for gap in held] == printed


def test_only_the_printed_gaps_are_called_published(four_speed: Controller) -> None:
    printed = {gap for gaps in PRINTED_GAPS.values() for gap in gaps}
    assert {written(gap) for gap in four_speed.gaps if gap.published} == printed


def test_pump_and_spool_6_as_printed(four_speed: Controller) -> None:
    assert four_speed.pump.displacement * 1e9 == pytest.approx(17100.3, abs=0.05)
    assert four_speed.pump.volumetric_efficiency == 0.95
    assert [land.nominal_diameter * 1e3 for land in four_speed.lands_of("6")] == pytest.approx(
        [9.939, 9.942], rel=1e-9, abs=0.0
    )


def test_everything_else_says_representative(four_speed: Controller) -> None:
    for land in four_speed.lands:
        assert {"contact_length_mm", "mounting_clearance_um"} <= set(land.representative)
        assert ("nominal_diameter_mm" in land.representative) == (land.component != "6")
