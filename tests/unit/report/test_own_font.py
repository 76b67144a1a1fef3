"""A font file that the workshop names, for characters that the report's own fonts lack."""

from __future__ import annotations

import io
from argparse import Namespace
from pathlib import Path

import pypdfium2
import pytest
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen

from atleak.cli import main
from atleak.cli.shared import print_font
from atleak.common.errors import InputError
from atleak.measurements.job_card import Job
from atleak.report.pdf import missing_characters, write_pdf
from atleak.report.printed_fonts import (
    FONTS,
    fitting,
    forget_font,
    keep_font,
    kept_file,
    kept_font,
    read_font,
    width_of,
)

NAME = "王小明"


def tiny_font(characters: str, family: str = "Noto Sans") -> bytes:
    """A font with a square for each of the characters, under the name of one of the report's own fonts."""
    pen = TTGlyphPen(None)
    pen.moveTo((100, 0))
    for corner in ((100, 800), (900, 800), (900, 0)):
        pen.lineTo(corner)
    pen.closePath()
    order = [".notdef", *(f"sign{number}" for number in range(len(characters)))]
    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder(order)
    builder.setupCharacterMap({ord(sign): name for sign, name in zip(characters, order[1:], strict=True)})
    builder.setupGlyf(dict.fromkeys(order, pen.glyph()))
    builder.setupHorizontalMetrics(dict.fromkeys(order, (1000, 100)))
    builder.setupHorizontalHeader(ascent=900, descent=-200)
    builder.setupNameTable({"familyName": family, "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    target = io.BytesIO()
    builder.save(target)
    return target.getvalue()


def first_page(content: bytes) -> str:
    with pypdfium2.PdfDocument(content) as document:
        return document[0].get_textpage().get_text_range()


def test_names_print_with_the_font_that_the_workshop_names_and_the_file_stays_archival(unmeasured) -> None:
    job, font = Job(customer={"name": NAME}), read_font(tiny_font(NAME), "tiny.ttf")
    plain, content = (write_pdf(unmeasured, job, sections=["signatures"], font=each) for each in (None, font))
    assert b"<pdfaid:part>" not in plain
    assert "U+738B" in first_page(plain)
    assert b"<pdfaid:part>2<" in content
    assert NAME in first_page(content)
    assert "U+738B" not in first_page(content)
    assert b"AtleakOwnFont" in content.replace(b"-", b"").replace(b" ", b"")
    assert content == write_pdf(unmeasured, job, sections=["signatures"], font=font)


def test_a_font_changes_no_report_that_has_no_need_of_it(unmeasured) -> None:
    font = read_font(tiny_font(NAME + "abc"), "tiny.ttf")
    reports = [write_pdf(unmeasured, Job(number="1"), sections=[], font=each) for each in (None, font)]
    assert reports[0] == reports[1]


def test_characters_that_no_font_has_are_named_in_a_message() -> None:
    job = Job(customer={"name": f"{NAME}!"}, notes="🛠")
    (without,) = missing_characters([job])
    assert "U+738B 王, U+5C0F 小, U+660E 明, U+1F6E0 🛠" in str(without.text)
    (left,) = missing_characters([job], read_font(tiny_font(NAME), "tiny.ttf"))
    assert "U+1F6E0 🛠, which show as boxes" in str(left.text)
    assert missing_characters([Job(customer={"name": "Łucja Παπαδοπούλου Привет"})]) == []


@pytest.mark.parametrize("content", [b"", b"no font", tiny_font("a")[:200], b"wOFF" + bytes(60), bytes(100_000)])
def test_a_file_that_is_no_font_is_refused_by_its_name(content: bytes) -> None:
    with pytest.raises(InputError, match=r"picture\.ttf.*expected a TrueType or OpenType font"):
        read_font(content, "picture.ttf")


def test_one_font_is_kept_until_another_one_or_none_is_asked_for(own_home: Path) -> None:
    assert kept_font() is None
    keep_font(tiny_font(NAME), "../one.ttf")
    keep_font(tiny_font("王"), "two.ttf")
    assert [each.name for each in own_home.rglob("*.ttf")] == ["two.ttf"]
    with pytest.raises(InputError):
        keep_font(b"no font", "three.ttf")
    assert kept_font().glyphs == {ord("王")}
    forget_font()
    assert kept_file() is None


def test_the_option_goes_before_the_font_that_is_kept_and_does_nothing_without_a_pdf(
    own_home: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    keep_font(tiny_font("王"), "kept.ttf")
    named = tmp_path / "named.ttf"
    named.write_bytes(tiny_font(NAME))
    assert print_font(Namespace(font=None), ["pdf"]).name == "kept.ttf"
    assert print_font(Namespace(font=str(named)), ["pdf", "xlsx"]).name == "named.ttf"
    assert print_font(Namespace(font=None), ["xlsx"]) is None
    assert capsys.readouterr().err == ""
    assert print_font(Namespace(font=str(named)), ["xlsx"]) is None
    assert "--font does nothing without --pdf" in capsys.readouterr().err
    with pytest.raises(InputError, match=r"missing\.ttf: cannot be read"):
        print_font(Namespace(font=str(tmp_path / "missing.ttf")), ["pdf"])


@pytest.mark.slow
def test_the_command_line_takes_a_font_and_tells_what_it_lacks(
    own_home: Path, tmp_path: Path, sample_readings: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    record, font, pdf = (tmp_path / name for name in ("job.toml", "tiny.ttf", "report.pdf"))
    record.write_text(f'[customer]\nname = "{NAME}"\n', encoding="utf-8")
    font.write_bytes(tiny_font("王小"))
    asked = ["diagnose", str(sample_readings), "--job", str(record), "--sections", "signatures", "--font", str(font)]
    main([*asked, "--pdf", str(pdf)])
    said = capsys.readouterr().err
    assert "the fonts of the PDF lack U+660E 明, which show as boxes" in said
    assert main([*asked[:-1], str(record), "--pdf", str(tmp_path / "other.pdf")]) == 2
    assert "no font can be read in it" in capsys.readouterr().err
    main(asked)
    assert "--font does nothing without --pdf" in capsys.readouterr().err


def test_text_is_measured_with_the_reports_font_and_cut_to_fit() -> None:
    assert width_of("0000", 10.0) == pytest.approx(4 * 5.72, abs=1e-9)
    assert width_of(NAME, 10.0) == pytest.approx(30.0, abs=1e-9)
    assert fitting("valve", 10.0, 100.0) == "valve"
    short = fitting("pressure regulator valve", 10.0, 60.0)
    assert short.endswith("…")
    assert width_of(short, 10.0) <= 60.0
    assert read_font((FONTS / "NotoSans-Bold.ttf").read_bytes(), "bold.ttf").glyphs > set(b"abc")
