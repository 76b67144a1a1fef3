"""Print the uncertainty budget of flagged lands: what makes each clearance uncertain, row by row."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from typing import Any

from atleak.catalogue.limits import RuleKind
from atleak.land_diagnosis import LandDiagnosis
from atleak.report.pdf.annex import coverage_factor
from atleak.report.pdf.blocks import Block, joined, listed, text
from atleak.report.pdf.printed_names import Part
from atleak.uncertainty import LandUncertainty, UnitUncertainty
from atleak.uncertainty.budget import MOST_BUDGETS, BudgetLine, budget_lines, combined
from atleak.views.table import Column
from atleak.workshop_units import PERCENT, UM

_OF_SHARE = 6  # of the sources of a share that are named


class Budget(Part):
    """The budgets of one report."""

    def blocks(self) -> Iterable[Block]:
        """Return a table for every flagged land that was measured, the worst first."""
        uncertainty, say = self.diagnosis.uncertainty, self.say
        flagged = [land for land in self.diagnosis.flagged if land.uncertainty and land.uncertainty.u_clearance]
        if uncertainty is None or not flagged:
            return
        yield text(say("annex.model"), leads=True)
        for land in flagged[:MOST_BUDGETS]:
            assert land.uncertainty is not None
            yield from self._of_land(land, land.uncertainty, uncertainty)
        if len(flagged) > MOST_BUDGETS:
            others = joined(map(self.names.land_number, flagged[MOST_BUDGETS:]))
            yield text(say("annex.more_budgets", lands=others))
        yield text(say("annex.about_budgets"), small=True)

    def _of_land(self, land: LandDiagnosis, its: LandUncertainty, unit: UnitUncertainty) -> Iterable[Block]:
        say, lines = self.say, budget_lines(its.sources)
        u, k = combined(lines), coverage_factor(unit)
        yield text(
            say(
                "annex.of_land",
                land=self.names.land_name(land),
                clearance=say.quantity(land.state.radial_clearance * UM, "clearance", 1),
                u=say.quantity(u * UM, "clearance", 2),
                expanded=say.quantity(k * u * UM, "clearance", 1),
                k=say.number(k, 2),
                coverage=say.percent(unit.coverage, 0),
            ),
            leads=True,
        )

        def of(line_of: Callable[[BudgetLine], Any], of_all: Any = "") -> Callable[[BudgetLine | None], Any]:
            """Return what stands in a column: something of a line, and something in the last row, of all together."""
            return lambda line: of_all if line is None else line_of(line)

        yield listed(
            say,
            [*lines, None],
            Column(
                "annex.source",
                width=250,
                of=of(lambda line: say.get("uncertainty_sources", line.source.label), say("annex.combined")),
            ),
            Column("annex.distribution", width=150, of=of(self._distribution)),
            Column("annex.degrees", digits=0, of=of(self._degrees)),
            Column("", digits=0, words="u(x)", of=of(self._input)),
            Column("", digits=0, words="c", of=of(self._sensitivity)),
            Column("", "clearance", 2, words="c · u(x)", of=of(lambda line: abs(line.contribution), u), times=UM),
            Column("annex.part_of_variance", "percent", 1, of=of(lambda line: line.fraction, 1.0), times=PERCENT),
            whole=True,
        )
        said = [self._of_wear(land, its), self._of_share(its)]
        if any(said):
            yield text(" ".join(filter(None, said)), small=True)

    def _distribution(self, line: BudgetLine) -> str:
        return f"{self.say(f'annex.{line.source.shape}')}, {'A' if line.statistical else 'B'}"

    def _degrees(self, line: BudgetLine) -> str:
        return self.say.number(line.degrees_of_freedom, 0) if math.isfinite(line.degrees_of_freedom) else "∞"

    def _input(self, line: BudgetLine) -> str:
        if line.input_kind == "temperature":
            return f"{self.say.plain(line.input_uncertainty, 3)}\u00a0K"
        return self.say.quantity(line.input_uncertainty * UM, "clearance", 2)

    def _sensitivity(self, line: BudgetLine) -> str:
        if line.input_kind == "temperature":
            return f"{self.say.value(line.sensitivity * UM, 'clearance', 3)}\u00a0{self.say.unit('clearance')}/K"
        return self.say.number(line.sensitivity, 1)

    def _of_wear(self, land: LandDiagnosis, its: LandUncertainty) -> str:
        """Return what the wear adds: the uncertainty of what the pair was when new."""
        rule = its.deciding
        if land.wear is None or rule is None or rule.rule.kind is not RuleKind.WEAR:
            return ""
        ranged = isinstance(land.state.land.mounting_clearance, tuple)
        return self.say(
            "annex.of_wear_range" if ranged else "annex.of_wear",
            mounting=self.say.quantity(its.sources.u_mounting * UM, "clearance", 2),
            limit=self.say.percent(rule.limit),
            u=self.say.percent(rule.standard_uncertainty),
        )

    def _of_share(self, its: LandUncertainty) -> str:
        """Return what makes a share uncertain where a share decides."""
        rule = its.deciding
        if rule is None or rule.rule.kind is not RuleKind.PAIR_SHARE or rule.rule.condition is None:
            return ""
        name = rule.rule.condition.name
        at = next((each for each in its.conditions if each.condition == name), None)
        if at is None or not math.isfinite(at.u_share) or not at.budget:
            return ""
        named = (
            f"{self.say.get('uncertainty_sources', source)} {self.say.percent(fraction, 0)}"
            for source, fraction in at.budget[:_OF_SHARE]
        )
        return self.say(
            "annex.of_share",
            condition=self.say.condition(rule.rule.condition),
            u=self.say.percent(at.u_share, 2),
            parts=joined(named),
        )
