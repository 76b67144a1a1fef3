"""The page of gauge studies: a workbook of readings to an instrument that the job uses."""

from __future__ import annotations

import numpy as np
import pytest
from streamlit.testing.v1 import AppTest

from atleak.catalogue.instruments import load_instrument
from tests.unit.pages.conftest import part_shown, press, texts

pytestmark = pytest.mark.page("20_Library?library=gauge_study")


def study_file() -> bytes:
    random = np.random.default_rng(7)
    rows = ["Teil;Prüfer;Wiederholung;Messwert [mm]"]
    rows += [
        f"{part};{'ABC'[who]};{trial};{12.7 + 0.01 * part + 0.001 * random.standard_normal():.4f}".replace(".", ",")
        for part, who, trial in np.ndindex(6, 3, 3)
    ]
    return "\n".join(rows).encode()


def test_a_study_is_judged_and_taken_as_an_instrument_of_the_job(app: AppTest) -> None:
    (upload,) = [each for each in app.main.file_uploader if each.key == "gauge-study-file-upload"]
    upload.upload("micrometer.csv", study_file(), "text/csv").run()
    assert not app.exception
    assert "of the study's variation is of gauge and people" in texts(app)
    press(app, "Take it as an instrument")
    assert part_shown(app) == "library=workshop_data"
    next(each for each in app.main.text_input if each.label.startswith("Name")).set_value("Our mike").run()
    press(app, "Save as own file")
    own = load_instrument("our_mike")
    assert own.repeatability == pytest.approx(1e-6, abs=0.3e-6)
    assert "micrometer.csv" in own.source
    press(app, "Measure sleeves with it")
    assert not app.exception
    assert app.session_state["atleak"].case.sleeve_instrument == "our_mike"


def test_a_file_without_readings_is_refused_in_words(app: AppTest) -> None:
    (upload,) = [each for each in app.main.file_uploader if each.key == "gauge-study-file-upload"]
    upload.upload("log.csv", b"time;rpm\n1;800\n", "text/csv").run()
    assert not app.exception
    assert "log.csv was not taken. log.csv: holds no table of repeated readings" in texts(app).replace("**", "")
