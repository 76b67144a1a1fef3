"""Everything that is wrong with a measuring sheet, listed at once."""

from __future__ import annotations

from collections.abc import Sequence

from atleak.errors import ReadingsError
from atleak.sentence import Sentence

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

    @property
    def sentence(self) -> Sentence:
        """Return the first ten problems, a line each."""
        if len(self.problems) == 1:
            return super().sentence
        count, file = len(self.problems), self.place.file
        said = Sentence("{count} problems in the readings:", count=count)
        if file:
            said = Sentence("{count} problems in {file}:", count=count, file=file)
        for problem in self.problems[:SHOWN]:
            said = Sentence("{problem}\n  {other}", problem=said, other=problem.sentence)
        if count > SHOWN:
            said = Sentence("{problem}\n  … and {count} more", problem=said, count=count - SHOWN)
        return said
