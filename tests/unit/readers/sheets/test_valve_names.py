"""Valves by names that nobody taught: told by the sizes measured under them, and by words, numbers and letters."""

from __future__ import annotations

import io
import re
import shlex
from functools import cache

import pytest
from openpyxl import Workbook

from atleak.catalogue.controller import Controller
from atleak.catalogue.controller_file import load_controller
from atleak.common.errors import ReadingsError
from atleak.readers.sheets.controller_names import ControllerNames
from atleak.readers.sheets.measuring_sheet import read_readings
from atleak.readers.sheets.valve_names import valves_by_name


@cache
def body(name: str) -> Controller:
    return load_controller(name)


def measured(name: str, **called: str) -> dict[str, dict[str, list[float]]]:
    """The diameters [mm] of valves of a body, each called by a name of the sheet's own."""
    return {
        text: {
            str(land.planes[0]): [1e3 * land.nominal_diameter - 0.01, 1e3 * land.nominal_sleeve_diameter + 0.03]
            for land in body(name).lands_of(component)
        }
        for component, text in called.items()
    }


def told(name: str, **called: str) -> dict[str, str]:
    return valves_by_name(ControllerNames(body(name)), measured(name, **called))


@pytest.mark.parametrize(
    ("name", "called"),
    [
        ("ford_4r70w", {"pressure_regulator": "Main reg", "boost_valve": "Boost", "manual_valve": "Man. v/v"}),
        ("ford_4r70w", {"shift_1_2": "1-2 shift", "shift_2_3": "2-3 shift", "shift_3_4": "3-4 shift"}),
        ("jatco_jf506e", {"shift_valve_a": "Valvola A", "shift_valve_b": "Valvola B", "shift_valve_c": "Valvola C"}),
        ("chrysler_41te", {"underdrive_accumulator": "UD acc", "overdrive_accumulator": "OD acc"}),
    ],
)
def test_sizes_and_words_tell_which_valve_a_name_means(name: str, called: dict[str, str]) -> None:
    assert told(name, **called) == {text: component for component, text in called.items()}


def test_of_valves_of_one_size_words_that_tell_nothing_leave_both_open() -> None:
    assert told("ford_4r70w", shift_1_2="this one", shift_2_3="that one") == {}


@pytest.mark.parametrize("text", ["Shift valve", "Válvula de cambio", "Clapet de commande"])
def test_a_name_that_any_valve_of_the_size_may_have_is_asked_about(text: str) -> None:
    for name in ("ford_4r70w", "gm_4l60e", "toyota_a340e"):
        assert told(name, shift_1_2=text) == {}


def test_a_size_that_no_valve_has_names_none() -> None:
    found = measured("ford_4r70w", boost_valve="Boost")
    found["Boost"]["1"] = [20.0, 20.03]
    assert valves_by_name(ControllerNames(body("ford_4r70w")), found) == {}


def sheet(names: dict[str, str], *, bores: bool = True) -> bytes:
    rows = ["Valve;Land;Spool [mm];Bore [mm]"]
    for component, text in names.items():
        for land in body("ford_4r70w").lands_of(component):
            spool, sleeve = 1e3 * land.nominal_diameter - 0.012, 1e3 * land.nominal_sleeve_diameter + 0.031
            rows.append(f"{text};{land.land};{spool:.3f};{sleeve if bores else 0:.3f}")
    return "\n".join(rows).encode()


CALLED = {"pressure_regulator": "Hauptdruckventil", "boost_valve": "Verstärker", "shift_1_2": "Umschalter 1-2"}
JAPANESE = ("主圧弁", "昇圧弁", "1-2シフト弁", "低速サーボ弁", "手動弁", "電磁調整弁")  # the same valves as in MORE
MORE = CALLED | {"low_servo_modulator": "Servo", "manual_valve": "Handschieber", "solenoid_regulator": "Magnetregler"}


def printed(error: ReadingsError) -> dict[str, str]:
    """The options that a refusal prints."""
    said = re.search(r"which column is what[^:]*:((?: --map (?:\"[^\"]+\"|\S+))+)", str(error))
    words = shlex.split(said[1] if said else "")
    return dict(word.split("=", 1) for word in words if word != "--map")


Sizes = dict[tuple[str, int, str], float]
SIZES: Sizes = {  # [mm] by valve, land and part
    (text, land.land, part): round(size, 3)
    for component, text in MORE.items()
    for land in body("ford_4r70w").lands_of(component)
    for part, size in (
        ("spool", 1e3 * land.nominal_diameter - 0.012),
        ("sleeve", 1e3 * land.nominal_sleeve_diameter + 0.031 * land.land),
    )
}
LANDS = list(dict.fromkeys((text, land) for text, land, _ in SIZES))


def by_letters() -> bytes:
    """Lands by letters, worn bores by a word of their own, and a name of who measured below."""
    rows = [
        f"{text};{'ABC'[land - 1]};{word};{size:.3f};{'ja' if land == 1 or part == 'spool' else 'nein'}"
        for (text, land, part), size in SIZES.items()
        for word in (("Kolli",) if part == "spool" else ("Reikä",))
    ]
    return "\n".join(["Venttiili;Kohta;Kappale;Mitta;Hyvä", *rows, ";;;Mittaaja;"]).encode()


def all_in_one_cell() -> bytes:
    """Valve, part and land in one cell, roundness in every second row, numbers counted in the first column."""
    rows = [
        f"{{}};{text}_{'Spool' if part == 'spool' else 'Bore'}_Land{land}_{what};{{:.4f}}".format(
            2 * at + more, 0.003 if more else size
        )
        for at, ((text, land, part), size) in enumerate(SIZES.items(), 1)
        for more, what in enumerate(("Diameter", "Roundness"))
    ]
    return "\n".join(["No.;Characteristic;Actual [mm]", *rows]).encode()


def from_nominal() -> bytes:
    """Deviations [µm] of spool and bore, each from its own nominal size."""
    rows = []
    for text, land in LANDS:
        spool, bore = SIZES[text, land, "spool"], SIZES[text, land, "sleeve"]
        new, new_bore = spool + 0.012, bore - 0.031 * land
        rows.append(f"{text};{land};{new:.3f};-12;{new_bore:.3f};{31 * land}")
    head = "Valve;Land;Spool drawing size (mm);Spool deviation (µm);Bore drawing size (mm);Bore deviation (µm)"
    return "\n".join([head, *rows]).encode()


def across() -> bytes:
    """A row for each valve, under headings of two rows in words that nobody knows."""
    book, target = Workbook(), io.BytesIO()
    sheet = book.active
    sheet.append(["밸브", "랜드 1", "", "랜드 2", "", "랜드 3", ""])
    sheet.append(["", *["스풀", "보어"] * 3])
    for first in "BDF":
        sheet.merge_cells(f"{first}1:{chr(ord(first) + 1)}1")
    for text in MORE.values():
        sheet.append([text, *(SIZES.get((text, land, part)) for land in (1, 2, 3) for part in ("spool", "sleeve"))])
    book.save(target)
    return target.getvalue()


def in_shift_jis() -> bytes:
    in_japanese = dict(zip(MORE.values(), JAPANESE, strict=True))
    rows = [
        f"{in_japanese[text]},第{land}ランド,{SIZES[text, land, 'spool']},{SIZES[text, land, 'sleeve']}"
        for text, land in LANDS
    ]
    return "\n".join(["部品名,ランド,外径,内径", *rows]).encode("shift_jis")


@pytest.mark.parametrize("content", [by_letters(), all_in_one_cell(), from_nominal(), across(), in_shift_jis()])
def test_a_sheet_of_a_shop_s_own_is_read_by_the_options_that_its_refusal_prints(content: bytes) -> None:
    ford, mapping = body("ford_4r70w"), dict[str, str]()
    for _ in range(3):
        try:
            read = read_readings(content, ford, name="own", mapping=mapping)
            break
        except ReadingsError as error:
            mapping |= printed(error)
            for text in re.findall(r'component …=([^"]+)"', str(error)):  # which only a person knows
                mapping |= {f"component {list(MORE)[JAPANESE.index(text)]}": text} if text in JAPANESE else {}
    found = {(each.component, each.plane, str(each.part)): round(1e3 * each.diameter, 3) for each in read.readings}
    valves = {text: component for component, text in MORE.items()}
    assert found == {(valves[text], str(land), part): size for (text, land, part), size in SIZES.items()}


def test_a_column_of_verdicts_is_no_column_of_parts() -> None:
    with pytest.raises(ReadingsError) as caught:
        read_readings(by_letters().replace(b"Kappale", b"Hm"), body("ford_4r70w"), name="own.csv")
    assert printed(caught.value)["part"] == "Hm"


NO_LANDS = (
    ("Date", "2024-05-01", "2024-06-03"),
    ("Inspection", "first", "second"),
    ("Verdict", "ok", "worn"),
    ("Checked by", "Anna", "Ben"),
    ("Where", "rear", "front"),
    ("Where", "C", "A"),
)


@pytest.mark.parametrize(("heading", "one", "other"), NO_LANDS)
def test_a_column_that_counts_no_lands_is_not_offered_as_one(heading: str, one: str, other: str) -> None:
    rows = [f"accumulator_1_2;{one};spool;21.99", f"accumulator_1_2;{one};bore;22.03"]
    for word, spool, bore in ((one, 10.98, 11.04), (other, 10.95, 11.09)):
        rows += [f"shift_2_3;{word};spool;{spool}", f"shift_2_3;{word};bore;{bore}"]
    with pytest.raises(ReadingsError) as caught:
        read_readings("\n".join([f"Valve;{heading};Part;Diameter [mm]", *rows]).encode(), body("ford_4r70w"))
    assert printed(caught.value).get("plane") in (None, "COLUMN")


STATES = {
    "two units, never in one row": "Valve;Land;Part;Unit A [mm];Unit B [mm]\nshift_1_2;1;spool;10.990;\n"
    "shift_1_2;1;bore;11.030;\nshift_2_3;1;spool;;10.991\nshift_2_3;1;bore;;11.031",
    "before and after": "Valve;Land;Part;Before repair [mm];After repair [mm]\nshift_1_2;1;spool;10.990;10.991\n"
    "shift_1_2;1;bore;11.030;11.031\nshift_2_3;1;spool;10.990;10.990\nshift_2_3;1;bore;;11.130",
    "two gearboxes": "Valve;Land;Gearbox 1 spool;Gearbox 1 bore;Gearbox 2 spool;Gearbox 2 bore\n"
    "shift_1_2;1;10.990;11.030;10.991;11.032\nshift_2_3;1;10.989;11.033;10.990;11.031",
    "drawing size and readings": "Valve;Land;Part;Drg [mm];R1 [mm];R2 [mm]\nshift_1_2;1;spool;11.000;10.998;10.999\n"
    "shift_1_2;1;bore;11.028;11.031;11.030\nshift_2_3;1;spool;11.000;10.997;10.997\n"
    "shift_2_3;1;bore;11.028;11.032;11.030",
    "two dates of one part": "Valve;Land;Bore May;Bore June\nshift_1_2;1;11.030;11.041\nshift_2_3;1;11.031;11.050",
}


@pytest.mark.parametrize("sheet", STATES.values(), ids=STATES)
def test_two_states_are_not_offered_as_repeats_or_as_spool_and_bore(sheet: str) -> None:
    with pytest.raises(ReadingsError) as caught:
        read_readings(sheet.encode(), body("ford_4r70w"))
    assert caught.value.offer == {}
    with pytest.raises(ReadingsError):
        read_readings(sheet.encode(), body("ford_4r70w"), mapping=printed(caught.value))


def test_a_sheet_of_which_no_column_says_the_part_ends_in_words() -> None:
    rows = [
        f"{valve};{part};1;{angle}°;{repeat};{size}"
        for valve, part, size in ((6, "spool", 9.939), (6, "sleeve", 10.031), (8, "spool", 10.0), (8, "øî¯g", 10.0))
        for angle in (0, 90)
        for repeat in (1, 2)
    ]
    sheet = "\r\n".join(["t;plane;direction;repeat;diameter [mm]", *rows])
    with pytest.raises(ReadingsError) as caught:
        read_readings(sheet.encode("cp1252"), body("four_speed_2023"))
    assert "make sense" not in str(caught.value)


def test_a_title_may_name_a_unit_beside_a_valve() -> None:
    of_unit = "Gearbox {} {}\nLand;Spool [mm];Bore [mm]\n1;{};{}\n"
    sheet = of_unit.format(1, "Main reg", 14.49, 14.54) + of_unit.format(2, "Line boost", 9.49, 9.54)
    words = {"component pressure_regulator": "Main reg", "component boost_valve": "Line boost"}
    with pytest.raises(ReadingsError, match="several units"):
        read_readings(sheet.encode(), body("ford_4r70w"), mapping=words)


@pytest.mark.parametrize(
    ("text", "encoding", "word"),
    [
        ("Valve;Land;Spool [mm];Bore [mm]\nboost_valve;1;9.49 ± 0.002;9.53", "cp1252", "9.49"),
        ("Valve;Land;Spool [µm];Bore [µm]\nboost_valve;1;9490;9530", "cp1252", "µm"),
        ("Zawór;Stopień;Średnica suwaka [mm];Średnica otworu [mm]\nboost_valve;1;9.49;9.53", "cp1250", "Średnica"),
        ("Zawór;Stopień;Średnica suwaka [mm];Średnica otworu [mm]\nboost_valve;1;9.49;9.53", "cp852", "Średnica"),
    ],
)
def test_few_letters_of_a_code_page_are_enough(text: str, encoding: str, word: str) -> None:
    readings = read_readings(text.encode(encoding), body("ford_4r70w"), with_cells=True)
    assert len(readings.readings) == 2
    assert word in str(readings.sheets)


def test_the_land_of_a_valve_with_one_land_may_be_left_empty() -> None:
    table = "Valve;Land;Spool [mm];Bore [mm]\naccumulator_1_2;;21.99;22.03\nboost_valve;1;9.49;9.53\n"
    assert len(read_readings(table.encode(), body("ford_4r70w")).readings) == 4
    with pytest.raises(ReadingsError, match="'Land' is empty"):
        read_readings(table.replace(";1;", ";;").encode(), body("ford_4r70w"))


def test_the_refusal_prints_the_names_that_settle_the_sheet_word_for_word() -> None:
    content = sheet(CALLED)
    with pytest.raises(ReadingsError, match="check which valve") as caught:
        read_readings(content, body("ford_4r70w"), name="own.csv")
    mapping = printed(caught.value)
    assert mapping == {f"component {component}": text for component, text in CALLED.items()}
    readings = read_readings(content, body("ford_4r70w"), name="own.csv", mapping=mapping)
    assert {reading.component for reading in readings.readings} == set(CALLED)


def test_a_zero_where_nothing_was_measured_ends_in_words() -> None:
    with pytest.raises(ReadingsError, match=r"own\.csv"):
        read_readings(sheet(CALLED, bores=False), body("ford_4r70w"), name="own.csv")


def test_bores_in_a_worksheet_of_their_own_are_read_though_its_title_names_the_gauge() -> None:
    titled = "Bores, bore gauge\nValve;Land;Reading 1\nboost_valve;1;9.53\n\nSpools, micrometer\nValve;Land;Reading 1\n"
    readings = read_readings((titled + "boost_valve;1;9.49\n").encode(), body("ford_4r70w"), name="own.csv").readings
    assert sorted(str(reading.part) for reading in readings) == ["sleeve", "spool"]


def test_bores_that_are_left_aside_are_warned_of_where_no_other_bore_is_read() -> None:
    table = "Valve;Land;Spool [mm];Bore min [mm];Bore max [mm]\nboost_valve;1;9.49;9.53;9.54\n"
    messages = read_readings(table.encode(), body("ford_4r70w"), name="own.csv").messages
    assert [each.level for each in messages if each.code == "column_aside"] == ["warning", "warning"]


def test_a_worksheet_that_no_mapping_fits_is_warned_of() -> None:
    book, target = Workbook(), io.BytesIO()
    for sheet, heading, land, diameter in ((book.active, "Vlv", 1, 9.49), (book.create_sheet("More"), "Wtf", 2, 12.98)):
        sheet.append([heading, "Ld", "S mm", "B mm"])
        sheet.append(["boost_valve", land, diameter, diameter + 0.04])
    target_columns = {"component": "Vlv", "plane": "Ld", "value spool": "S mm", "value sleeve": "B mm"}
    book.save(target)
    read = read_readings(target.getvalue(), body("ford_4r70w"), name="own.xlsx", mapping=target_columns)
    assert [each.level for each in read.messages if each.code == "sheet_aside"] == ["warning"]
