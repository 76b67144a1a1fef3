"""List what the catalogue holds, shipped and own: ``atleak controllers``, ``fluids``, ``limits`` and ``instruments``.

``atleak catalogue path`` names the folder of the user's own.
"""

from __future__ import annotations

import argparse
import sys
from typing import Any

from atleak.catalogue.controller_file import load_controller
from atleak.catalogue.entries import KINDS, Evidence, ListedEntry, listed_entries, own_folder
from atleak.catalogue.fluid import load_fluid
from atleak.catalogue.instruments import load_instrument
from atleak.catalogue.limits import load_limits
from atleak.cli.parser import add_command, add_group
from atleak.cli.shared import Outputs, add_force, add_json, add_units
from atleak.common.files import made_folder
from atleak.common.printable import asked_for
from atleak.common.wording import Wording, wording
from atleak.report.json.conditions import named_record
from atleak.report.json.diagnosis import limits_record
from atleak.report.tables.catalogue import evidence_counts, open_values
from atleak.report.terminal import print_records
from atleak.version import __version__


def add_parser(commands: Any, name: str) -> None:
    """Add one of the commands."""
    if name == "catalogue":
        own = add_group(commands, name, examples=("catalogue path",))
        about = "make the folder of your own catalogue and say where it is"
        add_command(own, "path", _path, about, quiet=False)
        return
    run = {"controllers": _controllers, "fluids": _fluids, "limits": _limits, "instruments": _instruments}[name]
    parser = add_command(commands, name, run, examples=(name, f"{name} --json -"))
    if name in ("fluids", "instruments"):
        add_units(parser)
    add_json(parser)
    add_force(parser)


def _path(options: argparse.Namespace) -> int:
    for kind in KINDS:
        made_folder(own_folder(kind))
    print(own_folder(), file=asked_for(sys.stdout))
    return 0


def _controllers(options: argparse.Namespace) -> int:
    known = listed_entries("controllers", load_controller)
    rows: list[dict[str, Any]] = [
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
            "still_to_measure": open_values(controller, wording("en")),
            "source": controller.source,
            "sha256": controller.sha256,
        }
        for controller in known.entries.values()
    ]
    heading = ", ".join(Evidence)
    shown = [{**row, heading: ", ".join(str(row["known_from"][evidence]) for evidence in Evidence)} for row in rows]
    status = _list(known, rows, ["id", "name", "lands", "gaps", heading], options, shown)
    if options.json != "-":
        for row in rows:
            if row["still_to_measure"]:
                print(f"{row['id']}: assumed, to be measured or looked up: {'; '.join(row['still_to_measure'])}.")
    return status


def _fluids(options: argparse.Namespace) -> int:
    known = listed_entries("fluids", load_fluid)
    rows = [
        {
            **named_record(fluid, "id", "name"),
            "viscosity_mm2_s": {f"{at:g}": nu * 1e6 for at, nu in fluid.points},
            "density_g_cm3": fluid.density_at[1] * 1e-3,
            "density_at_c": fluid.density_at[0],
            "pour_point_c": fluid.pour_point,
            "representative": list(fluid.representative),
            "note": fluid.note or None,
            "source": fluid.source,
            "sha256": fluid.origin.sha256,
        }
        for fluid in known.entries.values()
    ]
    return _list(known, rows, ["id", "name", "viscosity_mm2_s", "density_g_cm3", "pour_point_c"], options)


def _limits(options: argparse.Namespace) -> int:
    known = listed_entries("limits", load_limits)
    return _list(known, [limits_record(limits) for limits in known.entries.values()], ["id", "name", "source"], options)


def _instruments(options: argparse.Namespace) -> int:
    known = listed_entries("instruments", load_instrument)
    rows = [
        {
            **named_record(instrument, "id", "name"),
            "measures": list(instrument.measures),
            **named_record(instrument, "resolution_um", "calibration_um", "common_part", "repeatability_um"),
            "expansion_per_k": instrument.expansion,
            "representative": list(instrument.representative),
            "note": instrument.note or None,
            "source": instrument.source,
        }
        for instrument in known.entries.values()
    ]
    return _list(known, rows, ["id", "name", "measures", "resolution_um", "calibration_um", "common_part"], options)


def _list(
    known: ListedEntry[Any],
    rows: list[dict[str, Any]],
    columns: list[str],
    options: argparse.Namespace,
    shown: list[dict[str, Any]] | None = None,
) -> int:
    """Write the rows as JSON where that is asked for, and print them, or others that are shorter.

    Each says whether its entry is the user's own; own files that cannot be used are named.
    """
    outputs = Outputs(options)
    own = [{"own": entry.origin.own} for entry in known.entries.values()]
    records = [{**row, **mine, "atleak": __version__} for row, mine in zip(rows, own, strict=True)]
    outputs.write(json=lambda: records)
    if outputs.shown:
        listed = [{name: row[name] for name in columns} for row in shown or rows]
        if getattr(options, "units", "metric") != "metric":
            listed = [_in_units(row, wording("en", options.units)) for row in listed]
        names = list(listed[0]) if listed else columns
        print_records([*names, "own"], [{**row, **mine} for row, mine in zip(listed, own, strict=True)])
    outputs.say_written()
    for fault in known.faults:
        print(f"atleak: left aside: {fault}", file=sys.stderr)
    return 0


_KINDS = {"_mm2_s": "viscosity", "_g_cm3": "density", "_c": "temperature", "_um": "clearance"}  # by the end of a key


def _in_units(record: dict[str, Any], say: Wording) -> dict[str, Any]:
    """Return a record for a reader of other units than those in its keys."""
    shown = {}
    for name, value in record.items():
        end, kind = next(((end, kind) for end, kind in _KINDS.items() if name.endswith(end)), ("", None))
        if kind is None:
            shown[name] = value
            continue
        if isinstance(value, dict):  # by temperature
            points = ((say.plain_value(each, kind), float(at)) for at, each in value.items())
            value = ", ".join(f"{each} at {say.plain_quantity(at, 'temperature')}" for each, at in points)
        elif value is not None:
            value = say.plain_value(value, kind)
        shown[f"{name.removesuffix(end)} [{say.unit(kind)}]"] = value
    return shown
