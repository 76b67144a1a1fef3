"""Say by how much a number changed between two visits, and whether that is more than the measurements can be off."""

from __future__ import annotations

import math
from dataclasses import dataclass

from atleak.equations.uncertainty import normal_quantile
from atleak.uncertainty import LandUncertainty
from atleak.uncertainty.assess import COVERAGE
from atleak.uncertainty.results import Interval


@dataclass(frozen=True)
class Change:
    """A number before and after, in SI or as a fraction, and the 95 % interval of their difference.

    ``interval`` is None where one side has no interval of its own. ``standard_uncertainty`` is that of the difference,
    where it is normal.
    """

    before: float
    after: float
    interval: Interval | None
    standard_uncertainty: float | None = None

    @property
    def value(self) -> float:
        """Return the change: after minus before."""
        return self.after - self.before

    @property
    def significant(self) -> bool | None:
        """Return whether its interval leaves out zero; None where it has none."""
        return None if self.interval is None else not self.interval[0] <= 0.0 <= self.interval[1]


def clearance_change(before: LandUncertainty, after: LandUncertainty) -> Change | None:
    """Return by how much the radial clearance of a land changed [m]; None where one side did not measure it.

    Parameters
    ----------
    before, after
        the uncertainty of the land at each visit.

    Notes
    -----
    The change is significant where it is more than 1.96 times its standard uncertainty, the root of both variances: of
    lands that did not change, one in twenty at most is called changed.

    Both variances count in full. Two visits may share the certificate of a gauge, the form of a part that stayed in
    its place, or the true size of a part that nobody measured, and what they share drops out of the difference. But a
    sheet does not say whether the gauge was set with the same ring on both days, whether the part is the same one, nor
    at which angle it was turned: what is not known stays inside (choice of this project). All that can be
    shared acts in the same direction on both sides, so the true spread is never larger than this.
    """
    if before.u_clearance is None or after.u_clearance is None:
        return None
    u = math.hypot(before.u_clearance, after.u_clearance)
    first, second = (each.sources.state.radial_clearance for each in (before, after))
    reach = float(normal_quantile(0.5 + 0.5 * COVERAGE)) * u
    return Change(first, second, (second - first - reach, second - first + reach), u)


def change_between(before: float, after: float, interval: Interval | None) -> Change | None:
    """Return by how much a total or a pressure changed; None where it has no end on one of the sides.

    Parameters
    ----------
    before, after
        the values.
    interval
        the 95 % interval of the change, as `atleak.uncertainty.paired.changes` draws it; None where nothing was
        measured.
    """
    if not (math.isfinite(before) and math.isfinite(after)):
        return None
    known = interval is not None and all(map(math.isfinite, interval))
    return Change(before, after, interval if known else None)
