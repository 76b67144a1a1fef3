"""Name and draw the valves that have reached a limit, for a customer: on the casting's photo and as a schematic."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

from atleak.analysis.record_doubts import components_of
from atleak.catalogue.castings import sound_casting
from atleak.common.wording import isolated, joined
from atleak.measurements.job_card import RepairDecision
from atleak.report.charts.casting import casting_drawing
from atleak.report.charts.drawing import controller_svg
from atleak.report.pdf.blocks import Block
from atleak.report.printed_names import PrintedPart
from atleak.report.tables.complaint import WornValve, worn_valves
from atleak.report.tables.names import has_number, is_whole_body

_NAMED = 4  # valves that a sentence names
_ROW = 6  # valves that are drawn, beside one another
_ABREAST = 4  # for which there is room beside one another at the least, so that few are not drawn larger
_ON_SCREEN = 3  # valves beside one another: a phone is narrow
_LETTERS = 1.6  # against those of the drawing of all valves


class CustomerValves(PrintedPart):
    """The valves of one report as a customer is told of them."""

    @cached_property
    def worn(self) -> tuple[WornValve, ...]:
        """Return the valves that have reached a limit, the worst first."""
        return worn_valves(self.diagnosis, self.names.plan) if self.diagnosis.flagged else ()

    def name(self, component: str) -> str:
        """Name a valve by its name, its number behind it where it has one, or as it was typed."""
        name = isolated(self.say.name(self.diagnosis.controller.components.get(component, component)))
        return (
            f"{name} ({component})" if has_number(self.diagnosis.controller, component) and name != component else name
        )

    def named(self, components: Iterable[str]) -> str:
        """Name several valves; see `first`."""
        return self.first(map(self.name, components))

    def first(self, names: Iterable[str]) -> str:
        """Join names, each once: the first of them, and how many more."""
        names = [*dict.fromkeys(names)]
        named, more = joined(names[:_NAMED]), len(names) - _NAMED
        return named if more <= 0 else self.say("diagnosis.and_more", named=named, count=more)

    def about(self, decision: RepairDecision) -> str:
        """Name the valve that a decision is about, or those that a kit mends."""
        controller = self.diagnosis.controller
        components = components_of(decision, controller)
        return self.say("plan.whole_body") if is_whole_body(controller, components) else self.named(components)

    def drawings(self, *, on_screen: bool = False) -> list[Block]:
        """Return the drawings of the valves that have reached a limit, the best first: on the photo, and a schematic.

        Each states how small it may become. ``on_screen`` the photo is HTML, and the schematic narrow.
        """
        if not self.worn:
            return []
        drawn = [each.component for each in self.worn[:_ROW]]
        alt = self.say("customer.drawing_alt", valves=joined(map(self.name, drawn)))
        signs = sorted({each.urgency for each in self.worn[:_ROW]}, key=lambda each: -each.rank)
        svg = controller_svg(
            self.diagnosis.controller,
            {land.key: self.diagnosis.urgency_of(land) for each in self.worn for land in each.lands},
            columns=_ON_SCREEN if on_screen else max(len(drawn), _ABREAST),
            only=drawn,
            named=self.say.name,
            letters=_LETTERS,
            note=joined((self.say("customer.schematic"), *map(self.say.signed, signs)), " · "),
        )
        schematic = {"svg": svg, "alt": alt, "least": 0.8, "casting": False}
        casting = sound_casting(self.diagnosis.controller.id)
        if casting is None:
            return [schematic]
        urgent = {each.component: each.urgency for each in self.worn}
        photo = casting_drawing(casting, self.diagnosis, self.say, verdicts=urgent)
        shown = photo.html if on_screen else photo.svg
        return [{"svg": shown, "alt": alt, "least": 0.6, "casting": True}, schematic]

    def photo(self, pictures: Mapping[str, str]) -> dict[str, Any] | None:
        """Return the job's photo of the worst valve that has one."""
        of = {photo.component: photo for photo in reversed(self.job.photos)}
        shown = next((of[each.component] for each in self.worn if each.component in of), None)
        if shown is None or shown.file not in pictures:
            return None
        caption = joined((self.name(shown.component), shown.caption), " · ")
        return {"file": pictures[shown.file], "caption": caption, "alt": caption}
