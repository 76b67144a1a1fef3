"""Say what a reader must know of gaps: reversed drops, entry loss, turbulence, gaps that are partly closed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from atleak.catalogue.operating_point import OperatingPoint
from atleak.common.errors import Message
from atleak.common.sentences import Sentence
from atleak.common.units import PERCENT, UM, Quantity
from atleak.engine.leakage import GapLaw, GapLeakage
from atleak.equations import gap as gap_equations

#: Part of a gap's flow [-] from which on the entry loss is reported: choice of this project.
ENTRY_LOSS_WORTH_SAYING = 0.1


def gap_messages(law: GapLaw, gaps: Sequence[GapLeakage], condition: OperatingPoint) -> list[Message]:
    """Report reversed drops, a large entry loss and turbulence at one condition."""
    messages = []
    reversed_ = [gap for gap in gaps if gap.pressure_drop < 0 and not gap.leaks_back]
    if reversed_:
        text = Sentence(
            "{condition}: the pressure drop is negative and counts as no leakage at {lands}.",
            condition=condition,
            lands=_lands(reversed_),
        )
        messages.append(Message("warning", "reversed_pressure_drop", text))
    messages += _entry_loss_messages(law, gaps, condition)
    fast = [gap for gap in gaps if gap.reynolds_number > gap_equations.LAMINAR_REYNOLDS]
    if fast:
        text = Sentence(
            "{condition}: Reynolds number over {limit:g}, the flow may not be laminar, at {lands}.",
            condition=condition,
            limit=gap_equations.LAMINAR_REYNOLDS,
            lands=_lands(fast),
        )
        messages.append(Message("warning", "not_laminar", text))
    return messages


def narrow_gap_messages(gaps: Iterable[GapLeakage]) -> list[Message]:
    """Report once how many lands have a gap so narrow that its walls' boundary layer partly closes it.

    ``gaps`` are those of a unit at all its conditions.
    """
    clearances: dict[tuple[str, int], float] = {}  # the least of each land
    for gap in gaps:
        clearances[gap.gap.key] = min(gap.effective_clearance, clearances.get(gap.gap.key, np.inf))
    regime = gap_equations.obliteration(np.array(list(clearances.values())))
    narrow = np.count_nonzero(regime != "free")
    if not narrow:
        return []
    narrowest = min(clearances, key=lambda key: clearances[key])
    text = Sentence(
        "{narrow} of {lands} lands that leak have gaps of {free:g} {free.unit} or less at operating temperature, which "
        "the boundary layer partly closes: their leakage is an upper bound. The narrowest is {narrowest} with "
        "{clearance} {clearance.unit}.",
        narrow=int(narrow),
        lands=len(clearances),
        free=Quantity(gap_equations.FREE_CLEARANCE * UM, "clearance"),
        narrowest=named_land(narrowest),
        clearance=Quantity(clearances[narrowest] * UM, "clearance", 1),
    )
    return [Message("info", "partly_closed_gap", text)]


def _entry_loss_messages(law: GapLaw, gaps: Sequence[GapLeakage], condition: OperatingPoint) -> list[Message]:
    """Report how much of the flow by friction alone the entry loss takes, or would take, where that is much."""
    if not gaps:
        return []
    drop, clearance, length = np.array(
        [(gap.pressure_drop, gap.effective_clearance, gap.contact_length) for gap in gaps]
    ).T
    losses = law.entry_loss(drop, clearance, gaps[0].kinematic_viscosity, gaps[0].density, length)
    taken: dict[Sentence, float] = {}
    for gap, loss in zip(gaps, losses.tolist(), strict=True):
        if loss > ENTRY_LOSS_WORTH_SAYING:
            (land,) = _lands([gap])
            taken[land] = max(loss, taken.get(land, 0.0))
    if not taken:
        return []
    largest_first = sorted(taken.items(), key=lambda item: -item[1])
    amounts = tuple(Sentence("{loss:.0f} % at {land}", loss=loss * PERCENT, land=land) for land, loss in largest_first)
    if law.linear:
        text = Sentence(
            "{condition}: the entry loss is left out, so flows are too high. It would take off {amounts}.",
            condition=condition,
            amounts=amounts,
        )
        return [Message("warning", "entry_loss", text)]
    text = Sentence(
        "{condition}: of the flow by friction alone the entry loss takes off {amounts}.",
        condition=condition,
        amounts=amounts,
    )
    return [Message("info", "entry_loss", text)]


def _lands(gaps: Iterable[GapLeakage]) -> list[Sentence]:
    return sorted({named_land(gap.gap.key) for gap in gaps})


def named_land(key: tuple[str, int]) -> Sentence:
    """Name a land by component and number, as messages do: ``25 land 1``."""
    component, land = key
    return Sentence("{component} land {land}", component=component, land=land)
