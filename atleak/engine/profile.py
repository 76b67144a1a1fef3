"""Define profiles, which say how the engine computes: ``paper`` as the study, ``workshop`` with better physics."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace
from types import MappingProxyType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from atleak.catalogue.fluid import ViscosityModel
from atleak.catalogue.written_numbers import decimal_number
from atleak.common.errors import InputError, unknown
from atleak.common.sentences import Sentence

#: The eccentricity of a spool of which nobody knows where it lies: e/c uniform from 0 to 1, a choice of this project.
UNKNOWN: Literal["unknown"] = "unknown"


@dataclass(frozen=True)
class Profile:
    """The options that say how the engine computes.

    Attributes
    ----------
    name
        of the profile that it was made from.
    diameter
        ``spool``: the gap law with the spool's diameter, as the study prints. ``mean``: with spool diameter plus
        effective clearance, which agrees with the exact annulus to (c/r)²/60.
    viscosity
        ``tabulated``, ``d341`` or ``regression``: see `atleak.catalogue.fluid.Fluid.kinematic_viscosity`; the density
        follows the same choice.
    pump_draw
        ``all_gaps``: the sum of every gap, as the study. ``into_sump``: only what ends in the sump, so that flow into
        another section is not counted a second time when it leaves that section.
    pump_efficiency
        ``constant``: the controller's volumetric efficiency. ``wilson``: with the controller's slip coefficient,
        where it states one.
    entry_loss
        ``on``: every flow carries the loss of pressure that accelerates the fluid at a gap's entry and is lost at its
        exit. ``auto``: likewise, but over a log the gaps where it stays under 1 % are computed without it, which is
        quicker. ``off``: left out, as in the study.
    eccentricity
        e/c, the same for every gap: 0 concentric, 1 touching (2.5 times the flow), or `UNKNOWN`: every flow carries the
        mean over all positions of the spool.
    form
        ``mean_of_cubes``: flow follows the mean of the cubed clearances over the directions and planes measured.
        ``cube_of_mean``: the cube of their mean, as the study.
    circuits
        ``on``: circuits hold what their feeds can hold against their leaks, and the line what the pump can. ``off``:
        they hold what they are set to, or fed with, and the line what is required, as in the study.
    """

    name: str
    diameter: Literal["mean", "spool"]
    viscosity: ViscosityModel
    pump_draw: Literal["into_sump", "all_gaps"]
    pump_efficiency: Literal["wilson", "constant"]
    entry_loss: Literal["auto", "on", "off"]
    eccentricity: float | Literal["unknown"]
    form: Literal["mean_of_cubes", "cube_of_mean"]
    circuits: Literal["on", "off"]

    @property
    def options(self) -> dict[str, Any]:
        """Return every option but the name."""
        return {name: value for name, value in asdict(self).items() if name != "name"}

    @property
    def sets_position(self) -> bool:
        """Return whether an e/c was set; a spool that is only taken as concentric, or anywhere, may lie elsewhere."""
        return self.eccentricity not in (UNKNOWN, 0.0)

    @property
    def label(self) -> str:
        """Join the name and what was set apart from it: ``workshop, diameter=spool``."""
        base = PROFILES[self.name].options
        changed = [f"{name}={value}" for name, value in self.options.items() if base[name] != value]
        return ", ".join([self.name, *changed])

    def with_options(self, **options: Any) -> Profile:
        """Return this profile with some options set.

        Parameters
        ----------
        **options
            by the names of the attributes, values as they are or as text.

        Raises
        ------
        InputError
            unknown option, or a value that it does not take: naming the nearest.
        """
        return replace(self, **{name: _checked(name, value) for name, value in options.items()})


PAPER = Profile("paper", "spool", "tabulated", "all_gaps", "constant", "off", 0.0, "cube_of_mean", "off")
WORKSHOP = Profile("workshop", "mean", "d341", "into_sump", "wilson", "auto", 0.0, "mean_of_cubes", "on")
PROFILES = MappingProxyType({"workshop": WORKSHOP, "paper": PAPER})

_CHOICES: dict[str, tuple[str, ...]] = {
    name: get_args(hint) for name, hint in get_type_hints(Profile).items() if get_origin(hint) is Literal
}
_SWITCH = {"true": "on", "false": "off", "1": "on", "0": "off"}  # other words for the values of `entry_loss`


def find_profile(name: str, settings: dict[str, str] | None = None) -> Profile:
    """Find a profile by name.

    Parameters
    ----------
    name
        ``workshop`` or ``paper``.
    settings
        options as text, which replace the profile's own: ``{"eccentricity": "0.5"}``.

    Returns
    -------
    Profile
        with these options.

    Raises
    ------
    InputError
        unknown profile, option or value.
    """
    if name not in PROFILES:
        raise unknown(Sentence("no such profile"), name, PROFILES)
    return PROFILES[name].with_options(**(settings or {}))


def _checked(name: str, value: Any) -> Any:
    known = [field.name for field in fields(Profile) if field.name != "name"]
    if name not in known:
        raise unknown(Sentence("no such option"), name, known)
    if name in _CHOICES:
        written = str(value).lower()
        choice = _SWITCH.get(written, written) if name == "entry_loss" else value
        if choice not in _CHOICES[name]:
            raise unknown(_not_taken(name), value, _CHOICES[name])
        return choice
    if str(value).lower() == UNKNOWN:
        return UNKNOWN
    ratio = decimal_number(str(value))
    if ratio is None or not 0.0 <= ratio <= 1.0:
        expected = Sentence("a number 0 to 1, or {unknown}", unknown=UNKNOWN)
        raise InputError(_not_taken("eccentricity"), value=value, expected=expected)
    return ratio


def _not_taken(option: str) -> Sentence:
    return Sentence("option {option} does not take this value", option=option)
