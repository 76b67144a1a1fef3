"""The job record from a TOML or JSON file; the whole job as a zip that another atleak opens to the same verdict."""

from __future__ import annotations

import hashlib
import io
import json
import tempfile
import tomllib
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, ValidationError

from atleak import __version__
from atleak.controller import OperatingPoint, load_controller
from atleak.diagnosis import Diagnosis, diagnose
from atleak.errors import InputError, Place, nearest_name
from atleak.fluid import load_fluid
from atleak.instruments import Instruments, load_instruments
from atleak.intake.readings import read_readings
from atleak.intake.road_test import Understood, read_road_test, recall
from atleak.intake.road_test.names import words
from atleak.job import Job, picture_name
from atleak.limits import load_limits
from atleak.profile import find_profile
from atleak.report.record import diagnosis_record
from atleak.uncertainty import DEFAULTS, GUARD_FACTOR

FORMAT = 1
CATALOGUE = ("controller", "fluid", "limits", "spool_instrument", "sleeve_instrument")
SIZE_LIMIT = 1 << 30  # bytes of all files of a job, unpacked
_PICTURE_LIMIT = 40 << 20
_RECORD_LIMIT = 16 << 20
_ENTRIES = 1000
_STAMP = (1980, 1, 1, 0, 0, 0)  # of every file in the zip: the same job gives the same bytes
_LISTED = 8  # faults of a record that are named

Loaded = TypeVar("Loaded")


# --- the record alone


def load_job(path: str | Path) -> Job:
    """A job record from a ``.toml`` or ``.json`` file, with the pictures that lie beside it.

    Raises
    ------
    InputError
        naming file, table and key: what cannot be read, an unknown key, a value of the wrong kind, a picture that is
        missing.
    """
    path = Path(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise InputError(
            f"cannot be read: {error.strerror}", place=Place(file=str(path)), expected="a job record in TOML or JSON"
        ) from error
    if len(content) > _RECORD_LIMIT:
        raise InputError("too large for a job record", place=Place(file=path.name))
    job = parse_job(content, path.name)
    return job.with_pictures({name: _picture_beside(path, name) for name in job.picture_names})


def parse_job(content: bytes, name: str) -> Job:
    """A job record from the bytes of a TOML or JSON file, without its pictures.

    Raises
    ------
    InputError
        as `load_job`.
    """
    try:
        text = content.decode("utf-8-sig")
        data = json.loads(text) if Path(name).suffix.lower() == ".json" else tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        problem = f"is not valid: {str(error)[:200]}"
        raise InputError(problem, place=Place(file=name), expected="a job record in TOML or JSON, UTF-8") from error
    return _validated(Job, data, name)


def _picture_beside(record: Path, name: str) -> bytes:
    folder = record.resolve().parent
    path = (folder / name).resolve()
    place = Place(file=record.name, key=name)
    if not path.is_relative_to(folder):
        raise InputError("picture outside the job's folder", place=place)
    try:
        if path.stat().st_size > _PICTURE_LIMIT:
            raise InputError("picture too large", place=place, expected=f"at most {_PICTURE_LIMIT >> 20} MB")
        return path.read_bytes()
    except OSError as error:
        raise InputError(
            f"picture cannot be read: {error.strerror}", place=place, expected="a file beside the job record"
        ) from error


# --- the job with everything it rests on


@dataclass(frozen=True)
class SourceFile:
    """A file as it was given."""

    name: str
    content: bytes = field(repr=False)

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.content).hexdigest()


@dataclass(frozen=True)
class JobFile:
    """A job with its files and choices; `diagnose` computes it anew."""

    job: Job
    readings: SourceFile | None
    road_test: SourceFile | None
    catalogue: Mapping[str, SourceFile]  # by the names of `CATALOGUE`
    choices: Choices
    result: dict[str, Any]  # as it was written: the record of the diagnosis

    def diagnose(self) -> Diagnosis:
        """The diagnosis of this job by the atleak that reads it.

        Raises
        ------
        AtleakError
            a file that cannot be used.
        """
        choices = self.choices
        controller = load_source(load_controller, self.catalogue["controller"])
        fluid, limits = (
            load_source(load_fluid, self.catalogue["fluid"]),
            load_source(load_limits, self.catalogue["limits"]),
        )
        tools = [self.catalogue[name] for name in CATALOGUE[3:] if name in self.catalogue]
        instruments = load_source(load_instruments, *tools) if len(tools) == 2 else None
        readings = road_test = None
        if self.readings is not None:
            found = self.readings
            readings = read_readings(found.content, controller, name=found.name, **choices.readings.model_dump())
        if self.road_test is not None:
            found = self.road_test
            road_test = read_road_test(found.content, name=found.name, **choices.road_test)
        return diagnose(
            controller,
            fluid,
            limits,
            readings=readings,
            road_test=road_test,
            profile=find_profile(choices.profile, {name: str(value) for name, value in choices.options.items()}),
            condition=OperatingPoint(**choices.condition.model_dump()),
            mileage=choices.mileage,
            instruments=instruments,
            assumptions=DEFAULTS.with_settings(choices.assumptions),
            guard_factor=GUARD_FACTOR if choices.guard_factor is None else choices.guard_factor,
        )


def road_test_choices(
    log: Understood,
    mapping: Mapping[str, str],
    units: Mapping[str, str],
    *,
    remembered: Path,
    constants: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """How a log's columns were settled, now or earlier: what `write_job_file` takes, and `read_road_test` after it.

    Parameters
    ----------
    log
        as `atleak.intake.road_test.understand` understood it: earlier answers count only where it took them.
    mapping, units, constants
        as given with the log: they go before what was settled earlier.
    remembered
        the file in which earlier answers are kept.
    """
    consulted = any(message.code == "remembered" for message in log.messages)
    earlier = recall(remembered, log.signature) if consulted else None
    taken = {words(column) for column in mapping.values()}
    columns = {} if earlier is None else {name: one for name, one in earlier.mapping.items() if words(one) not in taken}
    found: dict[str, Any] = {
        "mapping": {**columns, **mapping},
        "units": {**({} if earlier is None else earlier.units), **units},
    }
    return found | ({"constants": dict(constants)} if constants else {})


def load_source(load: Callable[..., Loaded], *sources: SourceFile) -> Loaded:
    """What a loader of the catalogue makes of files that are at hand as bytes.

    A name that a user gave is only shown, in messages and records; no file of that name is written.

    Raises
    ------
    InputError
        as ``load``, naming the file as the user does.
    """
    with tempfile.TemporaryDirectory(prefix="atleak-") as folder:
        paths = [Path(folder) / f"own{number}.toml" for number, _ in enumerate(sources)]
        names = {path.name: source.name for path, source in zip(paths, sources, strict=True)}
        for path, source in zip(paths, sources, strict=True):
            path.write_bytes(source.content)
        try:
            return _named(load(*paths), names)
        except InputError as error:
            for fault in (*error.others, error):
                fault.place = replace(fault.place, file=names.get(fault.place.file or "", fault.place.file))
                fault.args = (str(fault),)
            raise


def _named(found: Any, names: Mapping[str, str]) -> Any:
    if isinstance(found, Instruments):
        return Instruments(_named(found.spool, names), _named(found.sleeve, names))
    return replace(found, origin=replace(found.origin, path=Path(names[found.origin.file])))


def write_job_file(
    diagnosis: Diagnosis,
    job: Job | None = None,
    *,
    readings: bytes | None = None,
    road_test: bytes | None = None,
    reading_choices: Mapping[str, Any] | None = None,
    road_test_choices: Mapping[str, Any] | None = None,
    catalogue: Mapping[str, bytes] | None = None,
) -> bytes:
    """The zip's bytes: job record, measuring sheet, log, pictures, catalogue files and result.

    Parameters
    ----------
    readings, road_test
        the bytes that the diagnosis was read from; required where it has them.
    reading_choices
        ``sheet``, ``unit`` and ``where`` as given to `read_readings`.
    road_test_choices
        ``mapping``, ``units`` and ``constants`` as given to `read_road_test`.
    catalogue
        bytes of controller, fluid, limits or instrument files that are no longer where they were loaded from.

    Raises
    ------
    InputError
        bytes that are missing, or not those that the diagnosis rests on.
    """
    job = job or Job()
    found = _catalogue_files(diagnosis, catalogue or {})
    sheet = _source(readings, diagnosis.readings, "the measuring sheet")
    log = _source(road_test, diagnosis.road.road_test if diagnosis.road else None, "the road-test log")
    sure = diagnosis.uncertainty
    choices = Choices(
        format=FORMAT,
        atleak=__version__,
        job=job,
        profile=diagnosis.profile.name,
        options=diagnosis.profile.options,
        condition=Condition(**asdict(diagnosis.projection.condition)),
        mileage=diagnosis.mileage,
        readings=ReadingChoices(**(reading_choices or {}) if sheet else {}),
        road_test=dict(road_test_choices or {}) if log else {},
        assumptions=sure.assumptions.settings if sure else {},
        guard_factor=sure.guard_factor if sure else None,
        files=_names(sheet, log, found),
    )
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as bundle:
        _add(bundle, "job.json", choices.model_dump_json(indent=2, exclude_defaults=True).encode())
        _add(bundle, "result.json", json.dumps(diagnosis_record(diagnosis), ensure_ascii=False, indent=2).encode())
        for name, source in (("readings", sheet), ("road_test", log)):
            if source is not None:
                _add(bundle, name, source.content)
        for name, source in found.items():
            _add(bundle, f"catalogue/{name}.toml", source.content)
        for name, content in sorted(job.pictures.items()):
            _add(bundle, f"pictures/{name}", content)
    return target.getvalue()


def read_job_file(source: str | Path | bytes, *, name: str = "job file", size_limit: int = SIZE_LIMIT) -> JobFile:
    """A job from its zip. Nothing is written to disk and no path of the zip is followed.

    Parameters
    ----------
    source
        a path, or the zip's bytes (then ``name`` names it in messages).
    size_limit
        bytes that it may unpack to.

    Raises
    ------
    InputError
        what is no job file, is damaged, would unpack to more than ``size_limit`` bytes, or holds entries that no job
        has.
    """
    name = name if isinstance(source, bytes) else Path(source).name
    place = Place(file=name)
    try:
        content = source if isinstance(source, bytes) else Path(source).read_bytes()
        with zipfile.ZipFile(io.BytesIO(content)) as bundle:
            entries = dict(_entries(bundle, name, size_limit))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", place=place, expected="a job file (zip)") from error
    except (zipfile.BadZipFile, zipfile.LargeZipFile, NotImplementedError, EOFError, RuntimeError, ValueError) as error:
        raise InputError(
            f"is no sound zip: {str(error)[:100]}", place=place, expected="a job file of atleak"
        ) from error
    return _job_file(entries, name)


def _job_file(entries: dict[str, bytes], name: str) -> JobFile:
    if "job.json" not in entries:
        raise InputError("holds no job.json", place=Place(file=name), expected="a job file of atleak")
    data = _json(entries["job.json"], f"{name}: job.json")
    made = data.get("format") if isinstance(data, dict) else None
    if made != FORMAT:
        raise InputError("job file of another format", place=Place(file=name), value=made, expected=f"format {FORMAT}")
    choices = _validated(Choices, data, f"{name}: job.json")
    result = _json(entries.get("result.json", b"{}"), f"{name}: result.json")
    sources = {}
    for slot, called in choices.files.items():
        entry = f"catalogue/{slot}.toml" if slot in CATALOGUE else slot
        if entry not in entries:
            raise InputError(f"holds no {entry}, which its record names", place=Place(file=name))
        sources[slot] = SourceFile(called, entries[entry])
    missing = [slot for slot in CATALOGUE[:3] if slot not in sources]
    if missing:
        raise InputError(f"names no {missing[0]}", place=Place(file=name), expected="a complete job file")
    pictures = {
        entry.removeprefix("pictures/"): found for entry, found in entries.items() if entry.startswith("pictures/")
    }
    return JobFile(
        job=choices.job.with_pictures(pictures),
        readings=sources.get("readings"),
        road_test=sources.get("road_test"),
        catalogue={slot: found for slot, found in sources.items() if slot in CATALOGUE},
        choices=choices,
        result=result,
    )


# --- what stands in job.json


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _plain_name(name: str) -> str:
    """A file's name without any folder: for messages, never for a path."""
    return PurePosixPath(name.replace("\\", "/")).name or "file"


class Condition(_Strict):
    """The stated condition, in SI."""

    name: str
    label: str
    temperature: float
    engine_speed: float
    gear: int
    main_pressure: float
    converter_pressure: float
    source: str


class ReadingChoices(_Strict):
    """What `read_readings` was told of the measuring sheet."""

    sheet: str | None = None
    unit: str | None = None
    where: dict[str, str] = {}


class Choices(_Strict):
    """Everything of a job but its files."""

    format: Literal[1]
    atleak: str
    job: Job = Job()
    profile: str
    options: dict[str, bool | float | str] = {}
    condition: Condition
    mileage: Annotated[float, Field(ge=0)] | None = None
    readings: ReadingChoices = ReadingChoices()
    road_test: dict[Literal["mapping", "units", "constants"], dict[str, str | float] | None] = {}
    assumptions: dict[str, float] = {}
    guard_factor: float | None = None
    files: dict[
        Literal["readings", "road_test", "controller", "fluid", "limits", "spool_instrument", "sleeve_instrument"],
        Annotated[str, AfterValidator(_plain_name)],
    ] = {}


# --- in and out of the zip


def _add(bundle: zipfile.ZipFile, name: str, content: bytes) -> None:
    entry = zipfile.ZipInfo(name, _STAMP)
    entry.compress_type = zipfile.ZIP_DEFLATED
    entry.external_attr = 0o600 << 16
    bundle.writestr(entry, content)


def _entries(bundle: zipfile.ZipFile, name: str, size_limit: int) -> Iterator[tuple[str, bytes]]:
    infos = bundle.infolist()
    place = Place(file=name)
    if len(infos) > _ENTRIES:
        raise InputError("holds too many files", place=place, value=len(infos), expected=f"at most {_ENTRIES}")
    names = [info.filename for info in infos]
    if len(set(names)) != len(names):
        raise InputError("holds a file twice", place=place, value=max(names, key=names.count))
    total = sum(info.file_size for info in infos)
    if total > size_limit:
        expected = f"at most {size_limit} bytes unpacked"
        raise InputError("too large", place=place, value=total, expected=expected)
    for info in infos:
        if info.is_dir():
            continue  # left by programs that zip folders
        if info.flag_bits & 0x1:
            raise InputError("is encrypted", place=place, value=info.filename)
        if not _known_entry(info.filename):
            raise InputError("holds a file that no job has", place=place, value=info.filename)
        yield info.filename, bundle.read(info)


def _known_entry(name: str) -> bool:
    if name in ("job.json", "result.json", "readings", "road_test"):
        return True
    if name in {f"catalogue/{slot}.toml" for slot in CATALOGUE}:
        return True
    if not name.startswith("pictures/"):
        return False
    picture = name.removeprefix("pictures/")
    try:
        return picture_name(picture) == picture
    except ValueError:
        return False


def _catalogue_files(diagnosis: Diagnosis, given: Mapping[str, bytes]) -> dict[str, SourceFile]:
    sure = diagnosis.uncertainty
    origins = {
        "controller": diagnosis.controller.origin,
        "fluid": diagnosis.fluid.origin,
        "limits": diagnosis.limits.origin,
        **(
            {
                "spool_instrument": sure.instruments.spool.origin,
                "sleeve_instrument": sure.instruments.sleeve.origin,
            }
            if sure
            else {}
        ),
    }
    found = {}
    for slot, origin in origins.items():
        if origin is None:
            continue  # an instrument made in Python: the catalogue's defaults are taken instead
        content = given.get(slot)
        if content is None:
            try:
                content = origin.path.read_bytes()
            except OSError as error:
                raise InputError(
                    f"the file of the {slot.replace('_', ' ')} is no longer there", value=origin.file
                ) from error
        source = SourceFile(origin.file, content)
        if source.sha256 != origin.sha256:
            raise InputError(
                f"the file of the {slot.replace('_', ' ')} has changed since it was loaded", value=origin.file
            )
        found[slot] = source
    return found


def _source(content: bytes | None, used: Any, called: str) -> SourceFile | None:
    if used is None:
        return None
    if content is None:
        raise InputError(f"{called} is missing", value=used.file, expected="the bytes the diagnosis was read from")
    source = SourceFile(used.file, content)
    if source.sha256 != used.sha256:
        raise InputError(f"{called} is not the one the diagnosis was read from", value=used.file)
    return source


def _names(sheet: SourceFile | None, log: SourceFile | None, catalogue: Mapping[str, SourceFile]) -> Any:
    sources = {"readings": sheet, "road_test": log, **catalogue}
    return {slot: source.name for slot, source in sources.items() if source is not None}


def _json(content: bytes, name: str) -> Any:
    if len(content) > _RECORD_LIMIT:
        raise InputError("too large", place=Place(file=name))
    try:
        return json.loads(content.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not valid JSON: {str(error)[:200]}", place=Place(file=name)) from error


# --- what is wrong with a record


def _validated(model: type[Any], data: Any, name: str) -> Any:
    try:
        return model.model_validate(data)
    except ValidationError as error:
        faults = error.errors(include_url=False)
        told = [_fault(fault, model, name) for fault in faults[:_LISTED]]
        first = told[0]
        if len(faults) > 1:
            more = "; ".join(str(found) for found in told[1:])
            first.problem += f" (and {len(faults) - 1} more: {more})"
            first.args = (str(first),)
        raise first from None


def _fault(fault: Any, model: type[BaseModel], name: str) -> InputError:
    location = [str(part + 1) if isinstance(part, int) else str(part) for part in fault["loc"]]
    table, key = " ".join(location[:-1]), location[-1] if location else None
    place = Place(file=name, table=table or None, key=key)
    if fault["type"] == "extra_forbidden":
        known = _keys(model, fault["loc"][:-1])
        expected = f"one of {', '.join(known)}" if known else None
        return InputError("unknown key", place=place, expected=expected, nearest=nearest_name(key or "", known))
    expected = fault["msg"].removeprefix("Value error, ").removeprefix("Input should be ")
    value = fault["input"]
    shown = value if isinstance(value, int | float | bool) else str(value)[:80]
    return InputError("value not accepted", place=place, value=shown, expected=expected)


def _keys(model: type[BaseModel], location: tuple[Any, ...]) -> list[str]:
    current: Any = model
    for part in location:
        if isinstance(part, str) and current is not None:
            found = current.model_fields.get(part)
            current = _model_of(found.annotation) if found else None
    return list(current.model_fields) if current is not None else []


def _model_of(annotation: Any) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for inner in getattr(annotation, "__args__", ()) if (found := _model_of(inner))), None)
