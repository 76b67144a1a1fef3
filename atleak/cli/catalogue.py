"""What the catalogue holds: ``atleak controllers``, ``fluids``, ``limits`` and ``instruments``."""

from __future__ import annotations

import argparse
from typing import Any

from atleak.cli.shared import add_command, add_force, add_json, check_targets, say_written, write_json
from atleak.version import __version__


def add_parser(commands: Any) -> None:
    """Add the commands."""
    for name, run in (
        ("controllers", _controllers),
        ("fluids", _fluids),
        ("limits", _limits),
        ("instruments", _instruments),
    ):
        parser = add_command(commands, name, run, f"the {name} of the catalogue")
        add_json(parser)
        add_force(parser)


def _controllers(options: argparse.Namespace) -> int:
    from atleak.catalogue.controller import controllers

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "components": len({land.component for land in found.lands}),
            "lands": len(found.lands),
            "gaps": len(found.gaps),
            "gears": list(found.gears),
            "operating_points": [point.name for point in found.operating_points],
            "representative": bool(found.representative),
            "source": found.source,
            "sha256": found.sha256,
        }
        for found in controllers()
    ]
    return _list(rows, ["id", "name", "lands", "gaps", "representative"], options)


def _fluids(options: argparse.Namespace) -> int:
    from atleak.catalogue.fluid import fluids

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "viscosity_mm2_s": {f"{at:g}": nu * 1e6 for at, nu in found.points},
            "density_g_cm3": found.density_at[1] * 1e-3,
            "density_at_c": found.density_at[0],
            "pour_point_c": found.pour_point,
            "representative": list(found.representative),
            "note": found.note or None,
            "source": found.source,
            "sha256": found.origin.sha256,
        }
        for found in fluids()
    ]
    return _list(rows, ["id", "name", "viscosity_mm2_s", "density_g_cm3", "pour_point_c"], options)


def _limits(options: argparse.Namespace) -> int:
    from atleak.catalogue.limits import limit_sets
    from atleak.views.diagnosis_record import limits_record

    rows = [limits_record(found) for found in limit_sets()]
    return _list(rows, ["id", "name", "source"], options)


def _instruments(options: argparse.Namespace) -> int:
    from atleak.catalogue.instruments import instruments

    rows = [
        {
            "id": found.id,
            "name": found.name,
            "measures": list(found.measures),
            "resolution_um": found.resolution * 1e6,
            "calibration_um": found.calibration * 1e6,
            "common_part": found.common_part,
            "repeatability_um": None if found.repeatability is None else found.repeatability * 1e6,
            "representative": list(found.representative),
            "note": found.note or None,
            "source": found.source,
        }
        for found in instruments()
    ]
    return _list(rows, ["id", "name", "measures", "resolution_um", "calibration_um", "common_part"], options)


def _list(rows: list[dict[str, Any]], columns: list[str], options: argparse.Namespace) -> int:
    check_targets(options, [], [("record", options.json)])
    if options.json is not None:
        say_written(write_json(options.json, [{**row, "atleak": __version__} for row in rows]))
    if options.json != "-":
        from atleak.report.terminal import print_table

        print_table(columns, rows)
    return 0
