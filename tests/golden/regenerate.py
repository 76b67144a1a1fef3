"""Writes the golden values of the sample job anew: ``python tests/golden/regenerate.py``.

Golden values say that nothing changed unnoticed. They are what this program computed once, not what is right: that is
for ``tests/literature``. Regenerate them after a change that is meant, and review the difference.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.limits import load_limits
from atleak.diagnosis.examination import diagnose
from atleak.engine.profile import PROFILES
from atleak.readers.logs import read_road_test
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.report.json.diagnosis import diagnosis_record

COMMAND = "python tests/golden/regenerate.py"
HERE = Path(__file__).resolve().parent
SAMPLE = HERE.parents[1] / "sample_data"
DIGITS = 12  # significant ones: more would differ from one processor to the next
ROAD_KEYS = (
    "rows", "duration_s", "gears", "sections",
    "max_leakage_sustained", "max_share_sustained", "max_leakage", "min_leakage", "max_share",
)  # fmt: skip
LAND_KEYS = ("radial_clearance_um", "wear_percent", "effective_clearance_um", "leakage_dm3_min", "share_percent")
CONDITION_KEYS = (
    "p_g_kpa",
    "p_s_kpa",
    "p_m_kpa",
    "p_k_kpa",
    "leakage_dm3_min",
    "pump_capacity_dm3_min",
    "share_percent",
    "band",
    "minimum_engine_rpm",
)


def golden_file(profile: str) -> Path:
    """Where the values of one profile stand."""
    return HERE / f"sample_job_{profile}.json"


def sample_job(profile: str) -> dict[str, Any]:
    """The key numbers of the sample job, computed now."""
    controller = load_controller("four_speed_2023")
    record = diagnosis_record(
        diagnose(
            controller,
            load_fluid("hipol_atf_iid"),
            load_limits("project_default"),
            readings=read_readings(SAMPLE / "measuring_sheet_four_speed.xlsx", controller),
            road_test=read_road_test(SAMPLE / "minimum_acceleration_test.csv"),
            profile=PROFILES[profile],
            mileage_km=106_315.0,
        )
    )
    return _rounded(_key_numbers(record))


def _key_numbers(record: dict[str, Any]) -> dict[str, Any]:
    road = record["road_test"]
    return {
        "verdict": record["verdict"],
        "projection": {key: record["projection"][key] for key in CONDITION_KEYS},
        "hot_idle": {key: record["hot_idle"][key] for key in CONDITION_KEYS},
        "lands": {
            _name(land): {**{key: _settled(land[key]) for key in LAND_KEYS}, "verdict": land["verdict"]}
            for land in record["lands"]
        },
        "gaps": {
            f"{_name(gap)} {gap['from']} to {gap['to']}": [gap["pressure_drop_kpa"], gap["leakage_mm3_s"]]
            for gap in record["gaps"]
        },
        "repair_plan": {_name(step): step["share_after_percent"] for step in record["repair_plan"]},
        "road_test": {key: road[key] for key in ROAD_KEYS},
        "message_codes": sorted({message["code"] for message in record["messages"]}),
    }


def _name(row: dict[str, Any]) -> str:
    return f"{row['component']}/{row['land']}"


def _settled(value: float | None) -> float | None:
    """Zero where only floating point is left of a value: wear of an unworn land is 1e-13 % or so."""
    return 0.0 if value is not None and abs(value) < 1e-9 else value


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(inner) for key, inner in value.items()}
    if isinstance(value, list):
        return [_rounded(inner) for inner in value]
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) else value


def main() -> None:
    """Compute both profiles and write their files."""
    for profile in PROFILES:
        path = golden_file(profile)
        text = json.dumps(sample_job(profile), ensure_ascii=False, indent=1)
        path.write_text(text + "\n", encoding="utf-8", newline="\n")
        print(f"written: {path.name}")


if __name__ == "__main__":
    main()
