"""The instrument catalogue: what ships, what a workshop's own file must say."""

from __future__ import annotations

from pathlib import Path

import pytest

from atleak.catalogue.instruments import STEEL_EXPANSION, instruments, load_instrument, load_instruments
from atleak.common.errors import CatalogueError, InputError


def test_shipped_instruments_state_their_source_and_what_is_representative() -> None:
    shipped = {instrument.id: instrument for instrument in instruments()}
    assert set(shipped) == {"air_gauge", "bore_gauge", "micrometer", "workshop_microscope"}
    for instrument in shipped.values():
        assert instrument.source
        assert instrument.date
        assert 0.0 < instrument.resolution <= 1e-6
        assert instrument.common**2 + instrument.own**2 == pytest.approx(instrument.calibration**2, rel=1e-12, abs=0.0)
        assert instrument.representative, instrument.id
        assert 5e-6 < instrument.expansion < 15e-6
    assert "resolution_um" not in shipped["workshop_microscope"].representative  # published by the source study
    assert "expansion_per_k" in shipped["workshop_microscope"].representative  # a scale of its own
    assert shipped["workshop_microscope"].resolution == pytest.approx(1e-6, rel=1e-12, abs=0.0)


def test_the_study_measured_spools_with_a_microscope() -> None:
    chosen = load_instruments()
    assert chosen.spool.id == "workshop_microscope"
    assert chosen.of("sleeve").id == "bore_gauge"


def test_a_micrometer_does_not_reach_into_a_bore() -> None:
    with pytest.raises(InputError, match="does not measure a sleeve") as raised:
        load_instruments("micrometer", "micrometer")
    assert "bore_gauge" in str(raised.value)


def test_a_mistyped_instrument_names_the_nearest() -> None:
    with pytest.raises(CatalogueError, match="did you mean 'micrometer'"):
        load_instrument("micrometre")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("common_part = 1.2", "common_part"),
        ("calibration_um = -1.0", "calibration_um"),
        ("resolution_um = 0", "resolution_um"),
        ('representative = ["age"]', "representative"),
        ("expansion_per_k = -1e-6", "expansion_per_k"),
        ("colour = 3", "colour"),
    ],
)
def test_a_wrong_value_is_named(tmp_path: Path, line: str, said: str) -> None:
    key = line.split(" = ")[0]
    good = {
        "id": '"own"',
        "name": '"Our own"',
        "source": '"certificate"',
        "date": '"2026-01-31"',
        "measures": '["sleeve"]',
        "resolution_um": "0.5",
        "calibration_um": "0.8",
        "common_part": "0.5",
    }
    file = tmp_path / "own.toml"
    file.write_text("\n".join(f"{name} = {value}" for name, value in good.items()), encoding="utf-8")
    own = load_instrument(file)
    assert own.repeatability is None
    assert own.expansion == STEEL_EXPANSION == 11.5e-6
    assert own.calibration == pytest.approx(0.8e-6, rel=1e-12, abs=0.0)
    rest = [f"{name} = {value}" for name, value in good.items() if name != key]
    file.write_text("\n".join([*rest, line]), encoding="utf-8")
    with pytest.raises(CatalogueError, match=said):
        load_instrument(file)


def test_a_file_without_its_source_is_refused(tmp_path: Path) -> None:
    text = Path(load_instrument("air_gauge").origin.path).read_text(encoding="utf-8")
    kept = [line for line in text.splitlines() if not line.startswith("source")]
    file = tmp_path / "air.toml"
    file.write_text("\n".join(kept), encoding="utf-8")
    with pytest.raises(CatalogueError, match="'source'"):
        load_instrument(file)
