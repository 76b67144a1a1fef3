"""Try every door with damaged files for a while: ``python -m tests.fuzz.run --seconds 80``.

Every file is made from a seed of `seeds` by `damage`. What came out of a door and should not have is counted by where
it came from, and one file of each kind is written to a folder, to be tried again with ``--again FILE --doors DOOR``.
"""

from __future__ import annotations

import argparse
import faulthandler
import os
import random
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from hypothesis import HealthCheck, Phase, given, seed, settings

PATIENCE = 300  # [s] for one file, before the program ends with what it was busy with
ROUND = 100  # files between two looks at the clock


@dataclass
class Tried:
    """What became of the files of one door."""

    files: int = 0
    refused: int = 0
    guarded: Counter[str] = field(default_factory=Counter)  # by the exception that a door's guard turned into an error
    wrong: Counter[str] = field(default_factory=Counter)  # by what came out


def main() -> int:
    """Try the doors; return 1 where anything but an error of the package came out."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=80.0, help="for all doors together: 80 unless given")
    parser.add_argument("--doors", help="with commas: all unless given")
    parser.add_argument("--seed", type=int, default=None, help="another one gives other files; any unless given")
    parser.add_argument("--keep", type=Path, help="folder for the files that something was wrong with")
    parser.add_argument("--again", type=Path, help="a file to try once more")
    options = parser.parse_args()
    # what is remembered on this computer is not touched, and a warning is no fault
    os.environ["ATLEAK_HOME"] = tempfile.mkdtemp(prefix="atleak-fuzz-")
    warnings.simplefilter("ignore")
    from .doors import passes
    from .seeds import DOORS

    doors = options.doors.split(",") if options.doors else DOORS
    if options.again:
        for door in doors:
            print(door, passes(door, options.again.name, options.again.read_bytes()))
        return 0
    start = random.randrange(1 << 32) if options.seed is None else options.seed
    keep = options.keep or Path(tempfile.mkdtemp(prefix="atleak-fuzz-files-"))
    print(f"seed {start}")
    total, wrong = 0, 0
    for number, door in enumerate(doors):
        tried = try_door(door, options.seconds / len(doors), start + number, keep)
        total, wrong = total + tried.files, wrong + sum(tried.wrong.values())
        print(f"{door:20} {tried.files:7} files, {tried.refused} refused", flush=True)
        for said, count in tried.wrong.most_common():
            print(f"    WRONG {count:5} × {said}", flush=True)
        for said, count in tried.guarded.most_common(12):
            print(f"    guard {count:5} × {said}", flush=True)
    print(f"{total} files tried, {wrong} of them wrong" + (f": see {keep}" if wrong else ""))
    return 1 if wrong else 0


def try_door(door: str, seconds: float, start: int, keep: Path) -> Tried:
    """Hand damaged files to a door until the time is over."""
    from .damage import damaged
    from .doors import GUARD, passes

    tried, until = Tried(), time.monotonic() + seconds

    def one(file: tuple[str, bytes]) -> None:
        tried.files += 1
        name, content = file
        faulthandler.dump_traceback_later(PATIENCE, exit=True)
        try:
            refused = passes(door, name, content)
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            note(tried.wrong, error, keep / f"{door}-{tried.files}-{name}", content)
        else:
            tried.refused += refused is not None
            if refused is not None and refused.problem.template == GUARD and refused.__cause__ is not None:
                note(tried.guarded, refused.__cause__, None, content)
        finally:
            faulthandler.cancel_dump_traceback_later()

    for number in _until(until):
        attempt = given(damaged(door))(one)
        quietly = settings(
            max_examples=ROUND, deadline=None, database=None, phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )  # fmt: skip
        seed(start + 1000 * number)(quietly(attempt))()
    return tried


def _until(end: float) -> Iterator[int]:
    number = 0
    while number == 0 or time.monotonic() < end:
        yield number
        number += 1


def note(counts: Counter[str], error: BaseException, path: Path | None, content: bytes) -> None:
    """Count what came out by its kind and the last line of the package that it went through."""
    lines = [line for line in traceback.extract_tb(error.__traceback__) if f"{os.sep}atleak{os.sep}" in line.filename]
    at = f"{Path(lines[-1].filename).name}:{lines[-1].lineno}" if lines else ""
    said = f"{type(error).__name__} {at} {str(error)[:80]!r}" if path else f"{type(error).__name__} {at}"
    if path is not None and said not in counts:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
        said_in = path.with_name(f"{path.name}.txt")
        said_in.write_text("".join(traceback.format_exception(error)), encoding="utf-8", errors="backslashreplace")
    counts[said] += 1


if __name__ == "__main__":
    sys.exit(main())
