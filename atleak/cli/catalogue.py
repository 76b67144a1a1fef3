"""List what the catalogue holds: ``atleak controllers``, ``fluids``, ``limits`` and ``instruments``."""

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
    from atleak.catalogue.controller_reading import controllers
    from atleak.catalogue.evidence import Evidence
    from atleak.views.evidence_rows import evidence_counts, still_to_measure

    rows = [
        {
            "id": controller.id,
            "name": controller.name,
            "components": len({land.component for land in controller.lands}),
            "lands": len(controller.lands),
            "gaps": len(controller.gaps),
            "circuits": [circuit.id for circuit in controller.circuits],
            "gears": list(controller.gears),
            "operating_points": [point.name for point in controller.operating_points],
            "complaints": [complaint.record for complaint in controller.complaints],
            "representative": bool(controller.representative),
            "known_from": evidence_counts(controller),
            "still_to_measure": still_to_measure(controller),
            "source": controller.source,
            "sha256": controller.sha256,
        }
        for controller in controllers()
    ]
    counts = [{evidence: row["known_from"][evidence] for evidence in Evidence} for row in rows]
    shown = [{**row, **count} for row, count in zip(rows, counts, strict=True)]
    status = _list(rows, ["id", "name", "lands", "gaps", *Evidence], options, shown)
    if options.json != "-":
        for row in rows:
            if row["still_to_measure"]:
                print(
                    f"{row['id']}: representative, to be measured or looked up: {'; '.join(row['still_to_measure'])}."
                )
    return status


def _fluids(options: argparse.Namespace) -> int:
    from atleak.catalogue.fluid import fluids

    rows = [
        {
            "id": fluid.id,
            "name": fluid.name,
            "viscosity_mm2_s": {f"{at:g}": nu * 1e6 for at, nu in fluid.points},
            "density_g_cm3": fluid.density_at[1] * 1e-3,
            "density_at_c": fluid.density_at[0],
            "pour_point_c": fluid.pour_point,
            "representative": list(fluid.representative),
            "note": fluid.note or None,
            "source": fluid.source,
            "sha256": fluid.origin.sha256,
        }
        for fluid in fluids()
    ]
    return _list(rows, ["id", "name", "viscosity_mm2_s", "density_g_cm3", "pour_point_c"], options)


def _limits(options: argparse.Namespace) -> int:
    from atleak.catalogue.limits import limit_sets
    from atleak.views.diagnosis_record import limits_record

    rows = [limits_record(limits) for limits in limit_sets()]
    return _list(rows, ["id", "name", "source"], options)


def _instruments(options: argparse.Namespace) -> int:
    from atleak.catalogue.instruments import instruments

    rows = [
        {
            "id": instrument.id,
            "name": instrument.name,
            "measures": list(instrument.measures),
            "resolution_um": instrument.resolution * 1e6,
            "calibration_um": instrument.calibration * 1e6,
            "common_part": instrument.common_part,
            "repeatability_um": None if instrument.repeatability is None else instrument.repeatability * 1e6,
            "expansion_per_k": instrument.expansion,
            "representative": list(instrument.representative),
            "note": instrument.note or None,
            "source": instrument.source,
        }
        for instrument in instruments()
    ]
    return _list(rows, ["id", "name", "measures", "resolution_um", "calibration_um", "common_part"], options)


def _list(
    rows: list[dict[str, Any]],
    columns: list[str],
    options: argparse.Namespace,
    shown: list[dict[str, Any]] | None = None,
) -> int:
    """Write the rows as JSON where that is asked for, and print them, or others that are shorter."""
    check_targets(options, [], [("record", options.json)])
    if options.json is not None:
        say_written(write_json(options.json, [{**row, "atleak": __version__} for row in rows]))
    if options.json != "-":
        from atleak.report.terminal import print_table

        print_table(columns, rows if shown is None else shown)
    return 0
