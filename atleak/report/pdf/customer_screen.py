"""Say what the customer's screen shows: what the first page of the report says, in fewer words.

Of personal data it holds plate and first name.
"""

from __future__ import annotations

from typing import Any

from atleak.analysis.changes import Comparison
from atleak.analysis.estimate import Line
from atleak.analysis.repair.options import decimals
from atleak.common.style import look_of
from atleak.common.wording import joined, wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.measurements.job_card import Job
from atleak.report.pdf.customer import CustomerPage, can_be_agreed_to
from atleak.report.printed_names import PrintedNames, PrintedPart

_ASKED = None, "proposed", "approved", "declined", "deferred"  # states that a customer may still change


def customer_screen(
    diagnosis: Diagnosis, job: Job, *, language: str = "en", units: str = "metric", visits: Comparison | None = None
) -> dict[str, Any]:
    """Return what the customer's screen shows, as JSON can keep it; `atleak.report.customer_screen` writes it.

    Parameters
    ----------
    diagnosis
        the frozen result.
    job
        what the workshop wrote down, and decided.
    language
        one of `atleak.common.wording.languages`: the customer's.
    units
        one of `atleak.common.units.SYSTEMS`.
    visits
        this result beside that of another visit of the unit.

    Raises
    ------
    InputError
        if language or units are unknown.
    """
    return _Screen(PrintedNames(diagnosis, job, wording(language, units)), visits).data


class _Screen(PrintedPart):
    """The screen of one diagnosis and its job."""

    def __init__(self, names: PrintedNames, visits: Comparison | None) -> None:
        super().__init__(names)
        self.page = CustomerPage(names, signed=False, visits=visits)

    @property
    def data(self) -> dict[str, Any]:
        page, job, look = self.page, self.job, look_of(self.page.verdict)
        day = self.say.date(job.date) if job.date else ""
        return {
            "language": self.say.language,
            "closed": False,
            "workshop": job.workshop.name,
            "about": joined((_first_name(job.customer.name), job.vehicle.registration, self.names.vehicle, day), " · "),
            "look": {"sign": look.sign, "tint": look.tint, "words": look.on_tint, "line": look.line},
            "headline": page.headline,
            "urgency": " ".join(page.urgency),
            "picture": next(iter(page.valves.drawings(on_screen=True)), None),
            "sentence": page.sentence,
            "bars": [*page.bars()],
            "bars_at": page.bars_at,
            "assumed": bool(self.diagnosis.provisional),
            "cost": self._cost(page),
        }

    def _cost(self, page: CustomerPage) -> dict[str, Any] | None:
        """Return the lines of the estimate that can be agreed to, or were, and their sum; None where there is none."""
        words = self.names.estimate
        if words is None:
            return None
        tax, currency = words.estimate.terms.tax_percent, words.estimate.currency
        return {
            "lines": [self._line(page, line) for line in page.lines()],
            "sum": words.summed(words.estimate.total.gross, words.estimate.total.complete),
            "complete": words.estimate.total.complete,
            "currency": currency,
            "digits": decimals(currency),
            "tax": tax or 0.0,
            "together": self.say(
                f"customer_screen.together{'_with_tax' if tax else ''}", tax=self.say.plain(tax or 0.0)
            ),
        }

    def _line(self, page: CustomerPage, line: Line) -> dict[str, Any]:
        words, state = self.names.estimate, line.decision.decision
        assert words is not None  # of which the line is
        return {
            "key": line.key,
            "valve": page.valves.about(line.decision),
            "work": words.work(line),
            "amount": words.amount(line) if can_be_agreed_to(line) else self.say("customer.not_yet"),
            "net": sum(float(each) for each in (line.part, line.work) if each is not None),
            "counts": line.carried_out,
            "asked": state in _ASKED and can_be_agreed_to(line),
            "state": "" if state in (None, "proposed") else self.say.get("job_decisions", state),
            "known": line.part is not None and line.work is not None,
            "agreed": {"approved": True, "declined": False}.get(state or ""),
        }


def _first_name(name: str) -> str:
    """Return the first of the names of a person, and nothing of one that may be a family's or a firm's."""
    family, comma, given = name.partition(",")
    names = (given if comma else family).split()
    return names[0] if names and (comma or len(names) == 2) and not names[0].endswith(".") else ""
