"""Everything that is wrong with a measuring sheet, listed at once."""

from __future__ import annotations

from collections.abc import Sequence

from atleak.errors import ReadingsError

SHOWN = 10


class ReadingsRefused(ReadingsError):
    """A measuring sheet that cannot be used, with every reason.

    ``place``, ``value``, ``expected`` and ``nearest`` are those of the first problem; ``problems`` holds them all, in
    the order of the sheet. The text lists the first ten.
    """

    def __init__(self, problems: Sequence[ReadingsError]) -> None:
        if not problems:
            raise ValueError("at least one problem")
        self.problems = tuple(problems)
        first = self.problems[0]
        super().__init__(
            first.problem, place=first.place, value=first.value, expected=first.expected, nearest=first.nearest
        )

    def __str__(self) -> str:
        if len(self.problems) == 1:
            return super().__str__()
        lines = [f"{len(self.problems)} problems in {self.place.file or 'the readings'}:"]
        lines += [f"  {problem}" for problem in self.problems[:SHOWN]]
        if len(self.problems) > SHOWN:
            lines.append(f"  … and {len(self.problems) - SHOWN} more")
        return "\n".join(lines)
