"""What a result has to say, in the reader's language and units."""

from __future__ import annotations

import datetime as dt
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from atleak import equations
from atleak.analysis.history.series import Visit, visits_in_order
from atleak.catalogue.controller import Controller
from atleak.catalogue.fluid import Fluid
from atleak.catalogue.limits import RuleKind
from atleak.common.errors import DomainError, translates_refusals
from atleak.common.sentences import Sentence, in_a_row, some
from atleak.common.units import Quantity
from atleak.common.wording import wording
from atleak.diagnosis.diagnosis import Diagnosis
from atleak.diagnosis.rules import Rule
from atleak.engine.leakage import LeakageModel
from atleak.engine.profile import WORKSHOP
from atleak.engine.road_leakage import evaluate_road_test
from atleak.equations._domain import positive, within
from atleak.equations.fluid import astm_d341
from atleak.equations.pump import face_slip
from atleak.measurements.clearances import clearances
from atleak.measurements.gauge_readings import Engine, GaugeCell
from atleak.measurements.road_test import RoadTest
from atleak.report.tables.sentences import rule_name

GERMAN, POLISH, US = wording("de"), wording("pl"), wording("en", "us")


def test_what_is_assumed_for_a_log_is_said_with_the_condition_and_in_the_reader_s_units(
    four_speed: Controller, hipol: Fluid, log_of: Callable[..., RoadTest]
) -> None:
    model = LeakageModel(four_speed, clearances(None, four_speed), hipol, WORKSHOP)
    log = log_of(np.arange(3.0), main_pressure=np.full(3, 8e5), engine_speed=np.full(3, 20.0))
    assumed = four_speed.operating_points[0]
    said = {each.code: each.text for each in evaluate_road_test(model, log, assumed).messages}
    text = said["assumed_atf_temperature"]
    assert text == f"The log has no atf temperature: 80 °C ({assumed.label}) is assumed for all of it."
    assert (
        US.sentence(text)
        == f"The log has no atf temperature: 176 °F ({US.condition(assumed)}) is assumed for all of it."
    )
    assert "80 °C angenommen (Fahrt im zweiten Gang" in GERMAN.sentence(text)
    assert POLISH.sentence(text).startswith("W zapisie nie ma temperatury ATF: dla całości przyjęto 80 °C (")
    assert "psi" in US.sentence(said["assumed_converter_pressure"])


def test_a_mileage_that_falls_is_said_in_the_reader_s_distances() -> None:
    visits = [Visit(dt.date(2026, month, 4), km, "own", ()) for month, km in ((3, 120_000.0), (5, 20_000.0))]
    (message,) = visits_in_order(visits).messages
    assert message.text.startswith(
        "The mileage falls from 120\u00a0000 km on 2026-03-04 to 20\u00a0000 km on 2026-05-04:"
    )
    assert "from 74\u00a0565 mi on 2026-03-04 to 12\u00a0427 mi on" in US.sentence(message.text)
    assert GERMAN.sentence(message.text).startswith("Die Laufleistung fällt von 120\u00a0000 km am 2026-03-04 auf")


def test_a_number_outside_an_equation_s_domain_is_said_in_the_reader_s_language() -> None:
    with pytest.raises(DomainError, match=r"^spring rate must be positive, found -2\.5 N/m at index 1$") as refused:
        translates_refusals(positive)("spring rate", [1.0, -2.5], "N/m")
    assert GERMAN.sentence(refused.value.sentence) == "Federrate: muss positiv sein, ist −2,5 N/m an der Stelle 1"


@pytest.mark.parametrize(
    ("check", "german"),
    [
        (lambda: within("volumetric efficiency", 1.5, 0.0, 1.0), "muss zwischen 0 und 1 sein, ist 1,5"),
        (lambda: within("temperature", 200.0, -40.0, 100.0, "°C"), "muss zwischen −40 und 100 °C sein, ist 200 °C"),
        (lambda: face_slip(1e-5, 0.04, 0.05), "muss größer als: Innendurchmesser sein, ist 0,04 m"),
        (lambda: astm_d341(-270.0, 8.9, 3.5), "muss eine, bei der ASTM D341 endlich ist, sein, ist −270 °C"),
    ],
)
def test_what_an_equation_refuses_reads_alike_alone_and_in_the_program(check: Callable[[], None], german: str) -> None:
    with pytest.raises(equations.DomainError) as alone:
        check()
    with pytest.raises(DomainError) as refused:
        translates_refusals(check)()
    assert str(pickle.loads(pickle.dumps(alone.value))) == str(refused.value)
    assert GERMAN.sentence(refused.value.sentence).endswith(german)


def test_where_a_gauge_or_a_log_showed_a_value_is_said_in_the_reader_s_language(sample: Diagnosis) -> None:
    where = Sentence("{range}, {engine}", range="D", engine=GaugeCell("D", Engine.FAST_IDLE).engine.label)
    steps = sample.pressure_rules[0].steps if sample.pressure_rules else sample.total_rules[0].steps
    rule = Rule(RuleKind.PERMISSIBLE_PRESSURE, None, 0.1, steps, where=where)
    assert rule.label == "main pressure below the permissible, D, fast idle"
    assert rule_name(rule, GERMAN) == "Hauptdruck unter dem zulässigen, D, erhöhter Leerlauf"


def test_a_value_far_below_one_is_written_without_an_exponent() -> None:
    small = Sentence("{step:g} {step.unit}", step=Quantity(1.0, "clearance"))
    assert (small, US.sentence(small)) == ("1 µm", "0.000039 in")
    assert GERMAN.plain(2.5e7) == "25000000"


def test_lists_are_said_in_the_reader_s_language() -> None:
    row = in_a_row([some(["25/1", "8/2", "8/3"], 2), Sentence("stall")])
    assert row == "25/1, 8/2 and 1 more; stall"
    assert GERMAN.sentence(row) == "25/1, 8/2 und 1 weitere; Festbremsen"
