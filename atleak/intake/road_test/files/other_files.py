"""Names files that are no log which can be read: pictures, archives, binaries, JSON, files of measured parts."""

from __future__ import annotations

import re
from pathlib import PurePath

from atleak.errors import Place, RoadTestError
from atleak.sentence import Sentence

_FORMS = Sentence("delimited text, xlsx, Parquet or MDF4 as the logger exports it")
_MAGIC = {
    b"\x89PNG": Sentence("a PNG picture"),
    b"\xff\xd8\xff": Sentence("a JPEG picture"),
    b"GIF8": Sentence("a GIF picture"),
    b"BM": Sentence("a bitmap picture"),
    b"II*\x00": Sentence("a TIFF picture"),
    b"MM\x00*": Sentence("a TIFF picture"),
    b"%PDF": Sentence("a PDF document"),
    b"{\\rtf": Sentence("a formatted text document"),
    b"Rar!": Sentence("a RAR archive"),
    b"7z\xbc\xaf": Sentence("a 7z archive"),
    b"TDSm": Sentence("a TDMS file of LabVIEW"),
    b"\x7fELF": Sentence("a program"),
    b"MZ\x90": Sentence("a program"),
    b"SQLite format 3": Sentence("a database"),
    b"PARE": Sentence("an encrypted Parquet file"),
    b"\x89HDF": Sentence("an HDF5 file"),
    b"MATLAB 5.0": Sentence("a MATLAB file"),
    b"MLVLG": Sentence("a binary log of {logger}", logger="MegaLogViewer"),
    b"LOGG": Sentence("a binary log of {logger}", logger="Vector (BLF)"),
    b"\xd7\x00\x00\x00lf": Sentence("a binary log of {logger}", logger="Link"),
    b"<?xml": Sentence("an XML document"),
    b"<!DOCTYPE": Sentence("a web page"),
    b"<html": Sentence("a web page"),
}
_DIADEM = re.compile(rb"\A\s*DIAEXTENDED|#BEGIN(?:GLOBAL|CHANNEL)HEADER")
_JSON = re.compile(rb'\A\s*(?:\{\s*["}]|\[\s*[\[{"\]])')
_Q_DAS = re.compile(rb"\A\s*K\d{4}(?:/\d+)?[ \t]", re.MULTILINE)
# what reports of coordinate measuring machines call their columns, in five languages
_PARTS = re.compile(
    r"\b(?:nominal|nennma(?:ß|ss)|nennwert|nominell|sollma(?:ß|ss)|meas|measured|actual|istma(?:ß|ss)|istwert|medido|atual"
    r"|mesur[ée]|dev|deviation|abweichung|abw|desvio|[ée]cart|outtol|out of tol|tol|toleranz|toler[âa]ncia|tol[ée]rance"
    r"|radius|raio|rayon|durchmesser|di[âa]metro|diam[èe]tre|diameter|circle|kreis|c[íi]rculo|cercle|cylinder|zylinder"
    r"|cilindro|cylindre|plane|ebene|plano|plan|nominalny|zmierzony|odchy[łl]ka|tolerancja|promie[ńn]|[śs]rednica)\b",
    re.IGNORECASE,
)
_SEVERAL = 4  # such words make a report
_TEXT = bytes({7, 8, 9, 10, 12, 13, 27} | set(range(0x20, 0x100)))
_BINARY_LOGS = {  # whose, by the ending of the name, of files that are no text
    ".emulog": "ECUMaster", ".emublog": "ECUMaster", ".emuprolog": "ECUMaster", ".fsl": "FORScan", ".llg": "Link",
    ".llg5": "Link", ".llgx": "Link", ".blf": "Vector (BLF)", ".hpl": "HP Tuners", ".xrk": "AiM", ".ld": "MoTeC",
}  # fmt: skip


def refuse_what_is_no_log(head: bytes, file: str) -> None:
    """Refuse a file whose first bytes show that it is no log, or none that can be read.

    Raises
    ------
    RoadTestError
        naming what it is.
    """
    place = Place(file=file)
    if not head.strip(b" \t\r\n\x00\xef\xbb\xbf\xff\xfe"):
        if head.strip(b" \t\r\n"):
            raise RoadTestError(
                Sentence("holds nothing but zero bytes: the logger did not finish writing it, or the card is damaged"),
                place=place,
            )
        raise RoadTestError(Sentence("is empty: the logger wrote nothing"), place=place)
    for magic, what in _MAGIC.items():
        if head.startswith(magic) and (magic != b"BM" or b"\x00" in head[:32]):
            problem = Sentence("is {what}, no road-test log, whatever its name says", what=what)
            raise RoadTestError(problem, place=place, expected=_FORMS)
    if _DIADEM.search(head):
        problem = Sentence("is the header file of a DIAdem recording: its numbers stand in another file")
        raise RoadTestError(problem, place=place, expected=Sentence("its channels exported as text"))
    if _JSON.match(head):
        problem = Sentence("is JSON: nothing tells which of its values are the rows of a log")
        raise RoadTestError(problem, place=place, expected=_FORMS)
    if _Q_DAS.match(head):
        problem = Sentence("is a Q-DAS file of measured parts (K fields), no road-test log")
        raise RoadTestError(problem, place=place, expected=Sentence("a log; diameters belong in a measuring sheet"))


def without_a_table(head: bytes, file: str) -> RoadTestError:
    """Return the error for a text in which no table was found, naming what it is where that can be told."""
    place, binary = Place(file=file), len(head.translate(None, _TEXT)) > 0.02 * len(head)
    if binary:
        logger = _BINARY_LOGS.get(PurePath(file).suffix.lower())
        problem = Sentence("is no text: a binary file of a form that is not known")
        if logger is not None:
            what = Sentence("a binary log of {logger}", logger=logger)
            problem = Sentence("is {what}, no road-test log, whatever its name says", what=what)
        return RoadTestError(problem, place=place, expected=_FORMS)
    return of_measured_parts(head, file) or RoadTestError(
        Sentence("no table of numbers was found in it"),
        place=place,
        expected=Sentence("a log with a header and rows of numbers, as the logger exports it"),
    )


def of_measured_parts(head: bytes, file: str) -> RoadTestError | None:
    """Return the error for a report of a coordinate measuring machine; None where it is none."""
    said = {word.lower() for word in _PARTS.findall(head.decode("utf-8", errors="replace"))}
    if len(said) < _SEVERAL:
        return None
    problem = Sentence("is a measuring machine's report of parts, no road-test log")
    expected = Sentence("a log; diameters belong in a measuring sheet")
    return RoadTestError(problem, place=Place(file=file), expected=expected)
