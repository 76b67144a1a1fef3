"""Profiles: two sets of options, and how one option is set alone."""

from __future__ import annotations

import pytest

from atleak.common.errors import InputError
from atleak.engine.profile import PAPER, PROFILES, WORKSHOP, find_profile


def test_workshop_comes_first_and_paper_is_as_printed() -> None:
    assert list(PROFILES) == ["workshop", "paper"]
    assert PAPER.options == {
        "diameter": "spool",
        "viscosity": "tabulated",
        "pump_draw": "all_gaps",
        "pump_efficiency": "constant",
        "entry_loss": "off",
        "eccentricity": 0.0,
        "form": "cube_of_mean",
        "circuits": "off",
    }
    assert WORKSHOP.options == {
        "diameter": "mean",
        "viscosity": "d341",
        "pump_draw": "into_sump",
        "pump_efficiency": "wilson",
        "entry_loss": "auto",
        "eccentricity": 0.0,
        "form": "mean_of_cubes",
        "circuits": "on",
    }


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("diameter", "spool", "spool"),
        ("viscosity", "regression", "regression"),
        ("pump_draw", "all_gaps", "all_gaps"),
        ("pump_efficiency", "constant", "constant"),
        ("entry_loss", "On", "on"),
        ("entry_loss", "off", "off"),
        ("entry_loss", "True", "on"),
        ("entry_loss", "0", "off"),
        ("eccentricity", "0,5", 0.5),
        ("eccentricity", "1", 1.0),
        ("eccentricity", "Unknown", "unknown"),
        ("form", "cube_of_mean", "cube_of_mean"),
    ],
)
def test_every_option_is_set_from_text_and_changes_nothing_else(name: str, text: str, value: object) -> None:
    profile = find_profile("workshop", {name: text})
    assert profile.options == {**WORKSHOP.options, name: value}
    assert profile.name == "workshop"


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("name", WORKSHOP.options)
def test_an_option_takes_its_own_value_back(profile: str, name: str) -> None:
    own = PROFILES[profile].options[name]
    assert PROFILES[profile].with_options(**{name: own}) == PROFILES[profile]


def test_a_profile_is_named_with_what_was_changed() -> None:
    assert WORKSHOP.label == "workshop"
    changed = find_profile("paper", {"diameter": "mean", "entry_loss": "on", "eccentricity": "0.5"})
    assert changed.label == "paper, diameter=mean, entry_loss=on, eccentricity=0.5"
    assert find_profile("paper", {"diameter": "spool"}).label == "paper"


@pytest.mark.parametrize(
    ("profile", "settings", "value", "expected", "nearest"),
    [
        ("papr", {}, "papr", "one of workshop, paper", "paper"),
        ("workshop", {"entry_los": "on"}, "entry_los", "one of diameter, viscosity", "entry_loss"),
        ("workshop", {"name": "mine"}, "name", "one of diameter", "diameter"),
        ("workshop", {"diameter": "men"}, "men", "one of mean, spool", "mean"),
        ("workshop", {"viscosity": "d314"}, "d314", "one of d341", "d341"),
        ("workshop", {"entry_loss": "maybe"}, "maybe", "one of auto, on, off", None),
        ("workshop", {"entry_loss": "outo"}, "outo", "one of auto, on, off", "auto"),
        ("workshop", {"form": "mean_of_cube"}, "mean_of_cube", "one of mean_of_cubes", "mean_of_cubes"),
        ("workshop", {"eccentricity": "1.01"}, "1.01", "a number 0 to 1, or unknown", None),
        ("workshop", {"eccentricity": "-0.1"}, "-0.1", "a number 0 to 1, or unknown", None),
        ("workshop", {"eccentricity": "nan"}, "nan", "a number 0 to 1, or unknown", None),
        ("workshop", {"eccentricity": "half"}, "half", "a number 0 to 1, or unknown", None),
        ("workshop", {"eccentricity": ""}, "", "a number 0 to 1, or unknown", None),
    ],
)
def test_what_is_no_profile_option_or_value_is_named(
    profile: str, settings: dict[str, str], value: str, expected: str, nearest: str | None
) -> None:
    with pytest.raises(InputError) as caught:
        find_profile(profile, settings)
    assert caught.value.value == value
    assert (caught.value.expected or "").startswith(expected)
    assert caught.value.nearest == nearest
