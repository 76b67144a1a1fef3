"""What was done in a session, as steps that can be taken back and done again: in a job, and from one job to the next.

A step takes back what it did, and nothing that was typed or chosen since.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeVar

from atleak.common.wording import Wording
from atleak.job.case import Case
from atleak.measurements.job_card import Job, Record

if TYPE_CHECKING:
    from pages.shared.cases import PageCase
    from pages.shared.state import InBook

Value = TypeVar("Value")
Told = Callable[[Wording], str]  # what was done, in the language of whoever reads it, which may change after it
_Entries = dict[tuple[Any, int], Any]
_ABOUT = ("file", "component", "land", "part", "repair", "name", "serial")  # what tells entries of a record apart
UNDOABLE = 10  # steps back that a session keeps


@dataclass(frozen=True)
class Step:
    """Something that was done in the job on the screen."""

    done: Told
    case: PageCase  # before it
    record: Job
    after: tuple[PageCase, Job] | None = None  # None until what was done is in the job

    def taken_back(self, case: PageCase, record: Job) -> tuple[PageCase, Job]:
        """Return a job as it stands now without what this step did."""
        after_case, after_record = self.after or (case, record)
        pictures = {**self.record.pictures, **record.pictures}
        kept = taken_back(record, after_record, self.record)
        return taken_back(case, after_case, self.case), kept.with_pictures(pictures)

    @property
    def turned(self) -> Step:
        """Return the step that does again what this one did, once it was taken back."""
        case, record = self.after or (self.case, self.record)
        return Step(self.done, case, record, (self.case, self.record))


@dataclass(frozen=True)
class Left:
    """A job that was on the screen before another one took its place."""

    done: Told
    case: PageCase
    record: Job
    in_book: InBook
    saved: bool  # the book holds it as it was left, so that it is opened from there, as it is by then
    steps: Steps


@dataclass(frozen=True)
class Steps:
    """The steps of the job on the screen: those that can be taken back, the last one last, and those taken back."""

    past: tuple[Step | Left, ...] = ()
    future: tuple[Step | Left, ...] = ()  # the one to be done again first is the last

    def with_step(self, step: Step | Left) -> Steps:
        """Return these with what was done last; what was taken back before can be done again no more."""
        return Steps((*self.past[1 - UNDOABLE :], step))

    def settled(self, case: PageCase, record: Job) -> Steps:
        """Return these with the job as the last step left it; what left it as it was is no step."""
        last = self.past[-1] if self.past else None
        if not isinstance(last, Step) or last.after is not None:
            return self
        if (last.case, last.record) == (case, record):
            return replace(self, past=self.past[:-1])
        return replace(self, past=(*self.past[:-1], replace(last, after=(case, record))))

    def without_jobs(self, ids: Collection[str]) -> Steps:
        """Return these without any way back to jobs of the book."""

        def kept(steps: tuple[Step | Left, ...]) -> tuple[Step | Left, ...]:
            each = (
                replace(step, steps=step.steps.without_jobs(ids)) if isinstance(step, Left) else step for step in steps
            )
            return tuple(step for step in each if not (isinstance(step, Left) and step.in_book.id in ids))

        return Steps(kept(self.past), kept(self.future))


def taken_back(now: Value, after: Value, before: Value) -> Value:
    """Return a value as it stands now without what changed it from ``before`` to ``after``.

    Fields are taken one by one, and so are the entries of a list; what has changed since stays as it is.

    >>> taken_back(("a", "b", "typed since"), ("a", "b"), ("a",))
    ('a', 'typed since')
    """
    if after == before:
        return now
    if now == after:
        return before
    found: Any = now  # whose kind says how its parts are reached
    if isinstance(now, Record):
        return found.model_copy(update=_parts_taken_back(vars(now), vars(after), vars(before)))
    if isinstance(now, Case):
        return replace(found, **_parts_taken_back(vars(now), vars(after), vars(before)))
    if isinstance(now, tuple) and isinstance(after, tuple) and isinstance(before, tuple):
        return found.__class__(_entries_taken_back(*map(_by_key, (now, after, before))))
    return now


def _entries_taken_back(now: _Entries, after: _Entries, before: _Entries) -> Iterator[Any]:
    """Return the entries of a list, those that were in it before in their order of then."""
    for key in (*before, *(key for key in now if key not in before)):
        if key in now and key in after and key in before:
            yield taken_back(now[key], after[key], before[key])
        elif key in now and now[key] != after.get(key):
            yield now[key]  # not of the step, or changed since
        elif key in before and key not in after:
            yield before[key]


def _by_key(entries: tuple[Any, ...]) -> _Entries:
    """Return the entries of a list by what they are about; of several about one thing each has its number."""
    found: _Entries = {}
    for entry in entries:
        about = tuple(getattr(entry, name, None) for name in _ABOUT) if isinstance(entry, Record) else entry
        found[about, sum(about == other for other, _ in found)] = entry
    return found


def _parts_taken_back(now: dict[str, Any], after: dict[str, Any], before: dict[str, Any]) -> dict[str, Any]:
    return {name: taken_back(value, after[name], before[name]) for name, value in now.items()}
