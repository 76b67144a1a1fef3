"""Read the job record from a TOML or JSON file, and write a whole job as a zip that gives the same verdict again."""

from __future__ import annotations

import io
import json
import tomllib
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from atleak.catalogue.circuit_tables import State
from atleak.catalogue.controller import OperatingPoint
from atleak.catalogue.entries import Origin, catalogue_files
from atleak.catalogue.fluid import FluidState
from atleak.diagnosis import Diagnosis
from atleak.engine.profile import find_profile
from atleak.errors import InputError, Place
from atleak.faults import validated
from atleak.job.case import OWN_FILES, SLOTS, Case, SourceFile, differing_options, pairs_of, plain_name, settings_of
from atleak.job.record import (
    Job,
    MeasuringCelsius,
    PumpSideMicrometres,
    PumpTipMicrometres,
    picture_name,
    without_surrogates,
)
from atleak.system.marks import NO_SOUND_ZIP, PACKINGS
from atleak.uncertainty import DEFAULTS, GUARD_FACTOR
from atleak.version import __version__
from atleak.views.diagnosis_record import diagnosis_record

FORMAT: Literal[1] = 1
SIZE_LIMIT = 1 << 30  # bytes of all files of a job, unpacked
_PICTURE_LIMIT = 40 << 20
_RECORD_LIMIT = 16 << 20
_ENTRIES = 1000
_STAMP = (1980, 1, 1, 0, 0, 0)  # date of every file in the zip, fixed so that the same job gives the same bytes


# --- the record alone


def load_job(path: str | Path) -> Job:
    """Read a job record from a ``.toml`` or ``.json`` file, with the pictures that lie beside it.

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
    """Read a job record from the bytes of a TOML or JSON file, without its pictures.

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
    return validated(Job, data, name)


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


# --- the job with all its files


@dataclass(frozen=True)
class JobFile:
    """A job as its zip contained it: the record, the case to diagnose anew, and the result as it was written."""

    job: Job
    case: Case
    result: dict[str, Any]
    name: str = "job file"  # of the zip, for messages

    def diagnose(self) -> Diagnosis:
        """Diagnose this job anew, with the installed version of atleak.

        Raises
        ------
        AtleakError
            a file that cannot be used; it names the zip and the file in it.
        """
        try:
            return self.case.diagnose()
        except InputError as error:
            error.rename_file(lambda file: f"{self.name}: {file}" if file else self.name)
            raise


def write_job_file(diagnosis: Diagnosis, job: Job | None = None, case: Case | None = None) -> bytes:
    """Return the bytes of the zip: job record, measuring sheet, log, gauges, pictures, catalogue files, result.

    Parameters
    ----------
    diagnosis
        the result.
    job
        what the workshop wrote down.
    case
        the files and choices that the result follows from, the log's columns as `with_log_choices` gives them; none for
        a unit that nobody measured or drove.

    Raises
    ------
    InputError
        files that are missing, or not those that the diagnosis rests on.
    """
    job, case = job or Job(), case or Case()
    entries = _catalogue_files(diagnosis, case)
    gauges = diagnosis.pressures.table if diagnosis.pressures else None
    of_tab = gauges if case.pressures is None else None
    sheet = _source(case.readings, diagnosis.readings or of_tab, "the measuring sheet")
    table = _source(case.pressures, None if gauges is of_tab else gauges, "the table of gauge readings")
    log = _source(case.road_test, diagnosis.log.road_test if diagnosis.log else None, "the road-test log")
    own = dict(zip(OWN_FILES, (sheet, log, table), strict=True))
    uncertainty = diagnosis.uncertainty
    choices = Choices(
        format=FORMAT,
        atleak=__version__,
        job=job,
        profile=diagnosis.profile.name,
        options=diagnosis.profile.options,
        condition=Condition(**settings_of(diagnosis.projection.condition)),
        mileage=diagnosis.mileage,
        readings=_reading_choices(case) if sheet else ReadingChoices(),
        fluid_state=None if diagnosis.fluid_state_assumed else diagnosis.fluid.state,
        complaint=diagnosis.complaint.id if diagnosis.complaint else None,
        repairs=[repair.id for repair in diagnosis.repairs],
        road_test=_log_choices(case) if log else {},
        assumptions=uncertainty.assumptions.settings if uncertainty else _assumptions(case),
        guard_factor=uncertainty.guard_factor if uncertainty else case.guard_factor,
        files=_names(own, entries),
    )
    target = io.BytesIO()
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as bundle:
        _add(bundle, "job.json", choices.model_dump_json(indent=2, exclude_defaults=True).encode())
        _add(bundle, "result.json", json.dumps(diagnosis_record(diagnosis), ensure_ascii=False, indent=2).encode())
        for name, source in own.items():
            if source is not None:
                _add(bundle, name, source.content)
        for name, source in entries.items():
            _add(bundle, f"catalogue/{name}.toml", source.content)
        for name, content in sorted(job.pictures.items()):
            _add(bundle, f"pictures/{name}", content)
    return target.getvalue()


def read_job_file(source: str | Path | bytes, *, name: str = "job file", size_limit: int = SIZE_LIMIT) -> JobFile:
    """Read a job from its zip; nothing is written to disk and no path of the zip is followed.

    Parameters
    ----------
    source
        a path, or the zip's bytes (then ``name`` names it in messages).
    size_limit
        bytes that it may unpack to.

    Raises
    ------
    InputError
        a file that is no job file, is damaged, would unpack to more than ``size_limit`` bytes, or holds entries that
        no job has.
    """
    name = name if isinstance(source, bytes) else Path(source).name
    place = Place(file=name)
    try:
        content = source if isinstance(source, bytes) else Path(source).read_bytes()
    except (OSError, ValueError) as error:
        problem = f"cannot be read: {getattr(error, 'strerror', error)}"
        raise InputError(problem, place=place, expected="a job file (zip)") from error
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as bundle:
            entries = dict(_entries(bundle, name, size_limit))
    except NO_SOUND_ZIP as error:
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
    choices = validated(Choices, data, f"{name}: job.json")
    result = _json(entries.get("result.json", b"{}"), f"{name}: result.json")
    sources = {}
    for slot, called in choices.files.items():
        entry = f"catalogue/{slot}.toml" if slot in SLOTS else slot
        if entry not in entries:
            raise InputError(f"holds no {entry}, which its record names", place=Place(file=name))
        sources[slot] = SourceFile(called, entries[entry])
    missing = [name for name, slot in SLOTS.items() if slot.required and name not in sources]
    if missing:
        raise InputError(f"names no {missing[0]}", place=Place(file=name), expected="a complete job file")
    pictures = {
        entry.removeprefix("pictures/"): content for entry, content in entries.items() if entry.startswith("pictures/")
    }
    return JobFile(choices.record.with_pictures(pictures), choices.case(sources), result, name)


# --- the content of job.json


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


def _known_slot(name: str) -> str:
    """Check that a name is one of the files that a job can hold."""
    if name not in (*OWN_FILES, *SLOTS):
        raise ValueError(f"one of {', '.join((*OWN_FILES, *SLOTS))}")
    return name


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
    stated_state: State | None = None
    solenoid_current: float | None = None
    lockup_duty: float | None = None
    values_of: str = ""


class ReadingChoices(_Strict):
    """The choices by which `read_readings` read the measuring sheet, and what was measured beside its diameters."""

    sheet: str | None = None
    unit: str | None = None
    where: dict[str, str] = {}
    measuring_temperature_c: MeasuringCelsius | None = None
    pump_side_clearance_um: PumpSideMicrometres | None = None
    pump_tip_clearance_um: PumpTipMicrometres | None = None

    @property
    def of_record(self) -> dict[str, float]:
        """Return what of it the job's record holds too."""
        names = ("measuring_temperature_c", "pump_side_clearance_um", "pump_tip_clearance_um")
        return {name: getattr(self, name) for name in names if getattr(self, name) is not None}


_LogChoices = dict[Literal["mapping", "units", "constants"], dict[str, str | float] | None]


class Choices(_Strict):
    """The content of ``job.json``: everything of a job but its files."""

    format: Literal[1]
    atleak: str
    job: Job = Job()
    profile: str
    options: dict[str, bool | float | str] = {}
    condition: Condition
    mileage: Annotated[float, Field(ge=0)] | None = None
    fluid_state: FluidState | None = None
    complaint: str | None = None
    repairs: list[str] = []
    readings: ReadingChoices = ReadingChoices()
    road_test: _LogChoices = {}
    assumptions: dict[str, float] = {}
    guard_factor: float | None = None
    files: dict[Annotated[str, AfterValidator(_known_slot)], Annotated[str, AfterValidator(plain_name)]] = {}

    @property
    def record(self) -> Job:
        """Return the job record with the measuring temperature and the pump's clearances that were chosen."""
        chosen = self.readings.of_record
        return self.job.model_copy(update=chosen) if chosen else self.job

    def case(self, sources: Mapping[str, SourceFile]) -> Case:
        """Return the case that these choices and files make up; nothing that this computer remembers is used."""
        profile = find_profile(self.profile, {name: str(value) for name, value in self.options.items()})
        return Case(
            profile=profile.name,
            options=differing_options(profile),
            point=OperatingPoint(**self.condition.model_dump()),
            mileage=self.mileage,
            measuring_temperature=self.record.measuring_temperature_c,
            pump_clearances=self.record.pump_clearances,
            fluid_state=self.fluid_state,
            complaint=self.complaint,
            repairs=tuple(self.repairs),
            sheet_name=self.readings.sheet,
            sheet_unit=self.readings.unit,
            sheet_where=pairs_of(self.readings.where),
            columns=pairs_of(self.road_test.get("mapping")),
            units=pairs_of(self.road_test.get("units")),
            constants=pairs_of(self.road_test.get("constants")),
            remember=False,
            assumptions=() if self.assumptions == DEFAULTS.settings else pairs_of(self.assumptions),
            guard_factor=None if self.guard_factor == GUARD_FACTOR else self.guard_factor,
        ).with_files(sources)


def _assumptions(case: Case) -> dict[str, float]:
    """Return the assumptions that were chosen: a log is judged with them also where nothing was measured."""
    return DEFAULTS.with_settings(dict(case.assumptions)).settings if case.assumptions else {}


def _reading_choices(case: Case) -> ReadingChoices:
    side, tip = case.pump_clearances.um
    return ReadingChoices(
        **case.sheet_choices,
        measuring_temperature_c=case.measuring_temperature,
        pump_side_clearance_um=side,
        pump_tip_clearance_um=tip,
    )


def _log_choices(case: Case) -> _LogChoices:
    chosen = case.log_choices
    columns: _LogChoices = {"mapping": {**chosen["mapping"]}, "units": {**chosen["units"]}}
    return columns | {"constants": {**chosen["constants"]}} if chosen["constants"] else columns


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
        if info.filename.endswith("/"):
            continue  # left by programs that zip folders
        if info.flag_bits & 0x1:
            raise InputError("is encrypted", place=place, value=info.filename)
        if info.compress_type not in PACKINGS:
            raise InputError("is packed in a way that no job is", place=place, value=info.filename, expected="deflate")
        if not _known_entry(info.filename):
            raise InputError("holds a file that no job has", place=place, value=info.filename)
        yield info.filename, bundle.read(info)


def _known_entry(name: str) -> bool:
    if name in ("job.json", "result.json", *OWN_FILES):
        return True
    if name in {f"catalogue/{slot}.toml" for slot in SLOTS}:
        return True
    if not name.startswith("pictures/"):
        return False
    picture = name.removeprefix("pictures/")
    try:
        return picture_name(picture) == picture
    except ValueError:
        return False


def _catalogue_files(diagnosis: Diagnosis, case: Case) -> dict[str, SourceFile]:
    """Return the catalogue files that the diagnosis used, each checked to be unchanged since it was loaded."""
    uncertainty = diagnosis.uncertainty
    used: dict[str, Any] = {name: getattr(diagnosis, name) for name, slot in SLOTS.items() if slot.required}
    if uncertainty is not None:
        used |= {"spool_instrument": uncertainty.instruments.spool, "sleeve_instrument": uncertainty.instruments.sleeve}
    files = {}
    for name, entry in used.items():
        origin, choice = entry.origin, getattr(case, name)
        if origin is None:
            continue  # an instrument made in Python: the catalogue's defaults are taken instead
        # the used state of a user's own fluid may be an entry of the catalogue
        shipped = origin.path in catalogue_files(SLOTS[name].folder).values()
        own = isinstance(choice, SourceFile) and not (shipped and choice.sha256 != origin.sha256)
        source = SourceFile(origin.file, choice.content if own else _bytes_loaded(name, origin))
        if source.sha256 != origin.sha256:
            what = f"the file of the {name.replace('_', ' ')}"
            raise InputError(f"{what} has changed since it was loaded", value=origin.file)
        files[name] = source
    return files


def _bytes_loaded(name: str, origin: Origin) -> bytes:
    try:
        return origin.path.read_bytes()
    except OSError as error:
        what = f"the file of the {name.replace('_', ' ')}"
        raise InputError(f"{what} is no longer there", value=origin.file) from error


def _source(source: SourceFile | None, used: Any, called: str) -> SourceFile | None:
    if used is None:
        return None
    if source is None:
        raise InputError(f"{called} is missing", value=used.file, expected="the bytes the diagnosis was read from")
    if source.sha256 != used.sha256:
        raise InputError(f"{called} is not the one the diagnosis was read from", value=used.file)
    return SourceFile(used.file, source.content)


def _names(own: Mapping[str, SourceFile | None], catalogue: Mapping[str, SourceFile]) -> dict[str, str]:
    return {slot: source.name for slot, source in {**own, **catalogue}.items() if source is not None}


def _json(content: bytes, name: str) -> Any:
    if len(content) > _RECORD_LIMIT:
        raise InputError("too large", place=Place(file=name))
    try:
        return _encodable(json.loads(content.decode("utf-8-sig")))
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not valid JSON: {str(error)[:200]}", place=Place(file=name)) from error


def _encodable(value: Any) -> Any:
    """Return what JSON holds with every text and key encodable, so that any report can be written of it."""
    if isinstance(value, dict):
        return {without_surrogates(key): _encodable(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_encodable(each) for each in value]
    return without_surrogates(value) if isinstance(value, str) else value
