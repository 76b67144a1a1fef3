"""Define the table of a pump in a controller's TOML file: what it displaces, and the gaps through which it slips."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from atleak.catalogue import usual_values as usual
from atleak.catalogue.entries import NonEmptyText, Positive, Strict
from atleak.catalogue.keys import key
from atleak.common.file_faults import NotAccepted
from atleak.common.sentences import Sentence

PumpKind = Literal["external_gear", "crescent", "gerotor", "vane"]

_Length = Annotated[float, Field(gt=0, lt=1000)]
_Clearance = Annotated[float, Field(gt=0, lt=2000)]
Count = Annotated[int, Field(ge=1, le=200)]

#: Keys that only the slip through a pump's gaps needs.
OF_GAPS = frozenset(
    {
        "ring_root_diameter_mm",
        "ring_outer_diameter_mm",
        "shaft_diameter_mm",
        "tip_land_mm",
        "sealing_tips",
        "side_clearance_um",
        "tip_clearance_um",
    }
)


def _key(heading: str, help: str, **more: Any) -> Any:
    """Return the field of a key that may be left out, and of which people say what its value is known from."""
    return key(heading, help, known=f"{heading} is", **{"default": None, **more})


class PumpTable(Strict):
    """A pump: ``displacement_mm3``, or the dimensions of one kind, from which its displacement follows."""

    kind: PumpKind | None = _key(
        "Kind",
        "external_gear: two equal gears side by side. crescent: a pinion in a ring gear. gerotor: a "
        "rotor with lobes in one that has one lobe more. vane: vanes in a round ring",
    )
    displacement_mm3: Positive | None = _key(
        "Displacement of one revolution",
        "What one revolution of the engine delivers without any loss; or give the dimensions",
        usual=usual.DISPLACEMENT,
    )
    module_mm: Positive | None = _key("Module", "Module of the teeth, where it is known")
    teeth: Count | None = _key("Teeth", "Teeth of each gear, of the pinion, or lobes of the inner rotor")
    width_mm: Positive | None = _key("Width", "Width of the gears, rotors or vanes along their axis")
    tooth_height_mm: Positive | None = _key("Height of a tooth", "Height of a tooth from root to tip")
    ring_teeth: Count | None = _key("Teeth of the ring gear", "Crescent: teeth of the ring gear")
    tip_diameter_mm: _Length | None = _key(
        "Diameter over the tips", "Over the tips of a gear, of the pinion, or of the inner rotor's lobes"
    )
    root_diameter_mm: _Length | None = _key(
        "Diameter at the roots", "At the roots of a gear, of the pinion, or between the inner rotor's lobes"
    )
    ring_tip_diameter_mm: _Length | None = _key(
        "Ring gear between tips", "Crescent: between opposite tips of the ring gear's teeth"
    )
    ring_root_diameter_mm: _Length | None = _key(
        "Ring gear between roots", "Crescent: between opposite roots of the ring gear's teeth"
    )
    ring_outer_diameter_mm: _Length | None = _key(
        "Outside of the ring gear or outer rotor", "Crescent and gerotor: outside of the ring gear or outer rotor"
    )
    centre_distance_mm: _Length | None = _key(
        "Distance of the axes",
        "Gears: from axis to axis. Crescent: half of the difference between the largest and the "
        "smallest distance from the shaft's bore to the pocket's wall",
    )
    vanes: Count | None = _key("Vanes", "Vane: how many vanes")
    cam_ring_diameter_mm: _Length | None = _key("Bore of the vanes' ring", "Vane: bore of the ring that they run in")
    rotor_diameter_mm: _Length | None = _key(
        "Diameter of the vanes' rotor",
        "Vane: outside of the rotor; it gives the stroke where eccentricity_mm is not stated",
    )
    eccentricity_mm: _Length | None = _key("Eccentricity", "Vane: of the ring against the rotor at full stroke")
    held_at_demand: bool = _key(
        "Held at demand",
        "true where the stroke falls to what is taken: shares and reserve are then of the full stroke",
        default=False,
    )
    shaft_diameter_mm: _Length | None = _key(
        "Shaft, hub or bushing", "Where the faces of gear or rotor end inside: shaft, hub or bushing"
    )
    tip_land_mm: _Length | None = _key(
        "Length of a tip's land", "Length of one tip along which it faces the wall, in the direction of turning"
    )
    sealing_tips: Count | None = _key(
        "Sealing tips", "Gears: tips of one gear that lie between delivery and suction at any moment, least"
    )
    side_clearance_um: _Clearance | None = _key(
        "Side clearance",
        "When new: axial play, depth of the pocket less width of gears or rotors",
        usual=usual.SIDE_CLEARANCE,
    )
    side_clearance_limit_um: _Clearance | None = _key(
        "Limit of the side clearance", "The most side clearance that the manual allows"
    )
    tip_clearance_um: _Clearance | None = _key(
        "Tip clearance", "When new: between the tips and what they seal against", usual=usual.TIP_CLEARANCE
    )
    tip_clearance_limit_um: _Clearance | None = _key(
        "Limit of the tip clearance", "The most tip clearance that the manual allows"
    )
    volumetric_efficiency: float = _key(
        "Volumetric efficiency",
        "Part of the displacement that is delivered, where no slip is known",
        usual=usual.EFFICIENCY,
        default=...,
        gt=0,
        le=1,
    )
    slip_coefficient: Positive | None = _key(
        "Slip coefficient", "Wilson's C_s of a new pump; side and tip clearances give it too"
    )
    source: NonEmptyText = key("Source", "Where these values are from")
    representative: list[str] = Field(default=[], description="Which of these keys hold representative values")
    measured: list[str] = Field(default=[], description="Which of these keys were measured by the workshop")
    published: list[str] = Field(default=[], description="Which of these keys are published; so are those of no list")

    @field_validator("representative", "measured", "published")
    @classmethod
    def _known(cls, names: list[str]) -> list[str]:
        for name in names:
            if name not in cls.model_fields:
                raise NotAccepted(Sentence("keys of this table, not {name!r}", name=name))
        return names

    @model_validator(mode="after")
    def _known_once(self) -> PumpTable:
        for name in self.published:
            if name in (*self.measured, *self.representative):
                raise NotAccepted(Sentence("{key} in one list alone", key=name))
        return self
