"""Say what a gauge study comes to: its record for scripts, and its sections for page and terminal."""

from __future__ import annotations

from typing import Any

from atleak.analysis.gauge_study import CATEGORY, SPREAD, GaugeStudy
from atleak.common.units import UM
from atleak.common.verdicts import Verdict
from atleak.common.wording import Wording
from atleak.report.charts.gauge_study_figures import component_chart
from atleak.report.json.conditions import message_record, named_record
from atleak.report.json.diagnosis import FORMAT
from atleak.report.tables.table import Column, Picture, Section, SectionPart, Table, Text
from atleak.version import __version__


def component_rows(study: GaugeStudy) -> list[dict[str, Any]]:
    """Return one row for each component of variation; deviations in µm, shares in percent, None where unknown."""
    return [
        {
            "component": component.name,
            "deviation_um": component.deviation * UM,
            "spread_um": SPREAD * component.deviation * UM,
            **named_record(component, "contribution_percent", "of_study_percent"),
            **({} if study.tolerance is None else named_record(component, "of_tolerance_percent")),
        }
        for component in study.components
        if not (study.pooled and component.name == "interaction")
    ]


def anova_rows(study: GaugeStudy) -> list[dict[str, Any]]:
    """Return one row for each source of the analysis of variance, in µm²."""
    return [
        {
            "source": row.source,
            "squares_um2": row.squares * UM**2,
            "freedom": row.freedom,
            "mean_square_um2": None if row.source == "total" else row.mean_square * UM**2,
            "f": row.f,
            "probability": row.probability,
        }
        for row in study.table
    ]


def study_record(study: GaugeStudy) -> dict[str, Any]:
    """Return everything a study says, as scripts read it: µm and percent; nothing is rounded."""
    readings = study.readings
    return {
        "format": FORMAT,
        "atleak": __version__,
        "file": readings.file,
        "sha256": readings.sha256 or None,
        "parts": list(readings.parts),
        "operators": list(readings.operators),
        **named_record(readings, "trials", "step_um"),
        **named_record(study, alpha="alpha", interaction_pooled="pooled", tolerance_um="tolerance"),
        "anova": anova_rows(study),
        "components": component_rows(study),
        **named_record(study.grr, grr_of_study_percent="of_study", grr_of_tolerance_percent="of_tolerance"),
        "categories": study.categories,
        "category_factor": CATEGORY,
        "judged": study.judged,
        "messages": [message_record(message) for message in study.messages],
    }


_VERDICTS = {"accepted": Verdict.OK, "marginal": Verdict.WATCH, "refused": Verdict.REPLACE}


def study_sections(study: GaugeStudy, say: Wording) -> dict[str, Section]:
    """Return the sections of a study by their names: the result, what the variation is made of, and its analysis."""
    verdict = _VERDICTS.get(study.judged or "", Verdict.NOT_MEASURED)
    drawn = Picture("components", component_chart(study, say), say("gauge_study.components"))
    parts: dict[str, tuple[SectionPart, ...]] = {
        "title": (Text(result_sentence(study, say), level=verdict),),
        "components": (drawn, component_table(study, say), Text(say("gauge_study.whose"), small=True)),
        "anova": (anova_table(study, say),),
    }
    return {name: Section(name, say(f"gauge_study.{name}"), of_name) for name, of_name in parts.items()}


def component_table(study: GaugeStudy, say: Wording) -> Table:
    """Return the components of variation as a table that people read."""
    shown = (
        Column("variation_part", of=lambda row: say(f"gauge_study_names.{row['component']}"), width=150),
        Column("deviation", "clearance", 3, of="deviation_um"),
        Column("spread", "clearance", 3, of="spread_um"),
        Column("contribution", "percent", 2, of="contribution_percent"),
        Column("of_study", "percent", 2, of="of_study_percent"),
        Column("of_tolerance", "percent", 2, of="of_tolerance_percent"),
    )
    return Table("components", shown, component_rows(study), say).filled


def anova_table(study: GaugeStudy, say: Wording) -> Table:
    """Return the analysis of variance as a table that people read."""
    shown = (
        Column("variation_source", of=lambda row: say(f"gauge_study_names.{row['source']}"), width=150),
        Column("squares", "clearance_squared", 2, of="squares_um2"),
        Column("freedom", digits=0),
        Column("mean_square", "clearance_squared", 2, of="mean_square_um2"),
        Column("f_ratio", digits=2, of="f"),
        Column("by_chance", digits=4, of="probability"),
    )
    return Table("anova", shown, anova_rows(study), say)


def result_sentence(study: GaugeStudy, say: Wording) -> str:
    """Say how much of what varies is of gauge and people, and how many groups of parts it tells apart."""
    if study.judged is None:
        return say("gauge_study.nothing")
    count = study.categories
    categories = say("gauge_study.no_categories") if count is None else say("gauge_study.categories", count=count)
    share, key = (
        (study.grr.of_study, "result") if study.tolerance is None else (study.grr.of_tolerance, "result_tolerance")
    )
    judged = say(f"gauge_study.{study.judged}")
    return say(f"gauge_study.{key}", grr=say.percent(share), judged=judged, categories=categories)
