"""What the dimensions of a pump displace, against chamber areas of generated rotors, and what slips past its faces."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from atleak.equations import DomainError, pump

Complex = np.ndarray  # outlines are points of the complex plane


def area(outline: Complex) -> float:
    """Area inside a closed outline, positive anticlockwise."""
    return 0.5 * float(np.sum((outline.conj() * np.roll(outline, -1)).imag))


# --- gerotor: a trochoid in circular lobes


def trochoid(lobes: int, ratio: float, lobe: float) -> tuple[float, float, float]:
    """Tip diameter, root diameter and swept area of a gerotor of eccentricity 1.

    The outer rotor has one lobe more: circles of radius ``lobe`` around points at ``ratio`` (lobes + 1) from its axis.
    The inner rotor's profile is what those circles leave; each touches it where the normal of its path points.
    """
    chambers = lobes + 1
    radius = ratio * chambers

    def path(t: np.ndarray) -> Complex:
        return radius * np.exp(1j * t) - np.exp(1j * chambers * t)

    def profile(t: np.ndarray) -> Complex:
        along = 1j * radius * np.exp(1j * t) - 1j * chambers * np.exp(1j * chambers * t)
        return path(t) + 1j * lobe * along / abs(along)

    areas = []
    for start in np.linspace(0.0, 2.0 * np.pi / lobes, 73):
        t = np.linspace(start, start + 2.0 * np.pi / chambers, 400)
        ends, between = path(t[[0, -1]]), profile(t)
        chord = ends[1] - ends[0]
        first, last = np.angle((between[0] - ends[0]) / chord), np.angle((between[-1] - ends[1]) / -chord)
        sectors = 0.5 * lobe * lobe * (first - last)  # of the outer rotor's lobes, which no fluid fills
        areas.append(-area(np.concatenate([ends[:1], between, ends[1:]])) - sectors)
    return 2.0 * (radius + 1.0 - lobe), 2.0 * (radius - 1.0 - lobe), lobes * (max(areas) - min(areas))


@pytest.mark.parametrize(
    ("lobes", "ratio", "lobe", "low"),
    [
        (4, 1.5, 3.5, -0.035),
        (5, 2.0, 4.0, -0.021),
        (6, 1.5, 3.0, -0.018),
        (6, 1.2, 2.5, -0.018),
        (8, 1.35, 2.5, -0.009),
        (8, 1.35, 4.0, -0.01),
        (9, 1.7, 4.0, -0.007),
        (13, 1.5, 3.0, -0.002),
    ],
)
def test_a_gerotor_displaces_what_its_chambers_change_by(lobes: int, ratio: float, lobe: float, low: float) -> None:
    tip, root, exact = trochoid(lobes, ratio, lobe)
    assert low < pump.gerotor_displacement(tip * 1e-3, root * 1e-3, 0.01, lobes) * 1e8 / exact - 1.0 < 0.0
    assert 1.005 < math.pi / 4.0 * (tip**2 - root**2) / exact < 1.065


# --- vane pump


@pytest.mark.parametrize("vanes", [7, 10, 13])
@pytest.mark.parametrize("eccentricity", [0.5, 3.0, 6.0])
def test_a_vane_pump_displaces_what_its_chambers_change_by(vanes: int, eccentricity: float) -> None:
    ring, rotor = 35.0, 28.5

    def chamber(middle: float) -> float:
        angle = np.linspace(middle - math.pi / vanes, middle + math.pi / vanes, 2000)
        reach = eccentricity * np.cos(angle) + np.sqrt(ring**2 - (eccentricity * np.sin(angle)) ** 2)
        outline = np.concatenate([reach * np.exp(1j * angle), rotor * np.exp(1j * angle[::-1])])
        return area(outline)

    exact = vanes * (chamber(0.0) - chamber(math.pi)) * 18.0
    formula = pump.vane_displacement(2e-3 * ring, eccentricity * 1e-3, 0.018, vanes) * 1e9
    assert formula == pytest.approx(exact, rel=0.3 * (eccentricity / ring) ** 2 + 1e-5, abs=0.0)


# --- gear pumps: involutes

WORKING = math.radians(20.0)


def outline(teeth: int, radius: float, low: float, high: float, begin: float, end: float, play: float = 0.0) -> Complex:
    """Outline of an involute gear from one tooth's flank, begun at one radius, to the next one's, ended at another.

    The space between the teeth of an internal gear has the same form. Under the base circle flanks are radial.
    """
    base, involute = radius * math.cos(WORKING), math.tan(WORKING) - WORKING
    half = 0.5 * math.pi / teeth + involute - play / radius

    def flank(radius: np.ndarray) -> np.ndarray:
        roll = np.sqrt(np.maximum((radius / base) ** 2 - 1.0, 0.0))
        return half - (roll - np.arctan(roll))

    pitch = 2.0 * math.pi / teeth
    down, up, back = np.linspace(begin, low, 400), np.linspace(low, high, 400), np.linspace(high, end, 400)
    root = np.linspace(flank(low), pitch - flank(low), 100)
    tip = np.linspace(pitch - flank(high), pitch + flank(high), 100)
    return np.concatenate(
        [
            down * np.exp(1j * flank(down)),
            low * np.exp(1j * root),
            up * np.exp(1j * (pitch - flank(up))),
            high * np.exp(1j * tip),
            back * np.exp(1j * (pitch + flank(back))),
        ]
    )


def in_mesh(teeth: int, radius: float, low: float, high: float, contacts: Complex, play: float = 0.0) -> Complex:
    """Turn that outline so that it begins in one point of contact; it must then end in the other."""
    begin, end = abs(contacts)
    assert low < min(begin, end) < max(begin, end) < high
    part = outline(teeth, radius, low, high, begin, end, play)
    part = part * contacts[0] / part[0]
    assert abs(part[-1] - contacts[1]) < 1e-9
    return part


def delivered(teeth: int, other: int, tip: float, other_tip: float, internal: bool) -> float:
    """Area that two involute gears of module 1 deliver in a turn of the first: all spaces' fluid less what comes back.

    What comes back is the pocket between two points of contact, half a base pitch before and after the pitch point.
    """
    radius, other_radius = 0.5 * teeth, 0.5 * other
    contacts = radius + 1j * np.exp(-1j * WORKING) * 0.5 * math.pi * math.cos(WORKING) * np.array([-1.0, 1.0])
    first = in_mesh(teeth, radius, radius - 1.3, tip, contacts, play=0.02)
    whole = outline(teeth, radius, radius - 1.3, tip, tip, tip, play=0.02)
    if internal:
        axis, ends = radius - other_radius, (other_tip, other_radius + 1.3)
        second = (axis + in_mesh(other, other_radius, *ends, contacts - axis))[::-1]
    else:
        axis, ends = radius + other_radius, (other_radius - 1.3, other_tip)
        second = axis - in_mesh(other, other_radius, *ends, axis - contacts[::-1], play=0.02)
    other_whole = outline(other, other_radius, *ends, ends[1], ends[1], play=0.0 if internal else 0.02)
    pocket = -area(np.concatenate([first, second]))

    def space(outline: Complex, rim: float, count: int) -> float:
        return abs(math.pi * rim * rim / count - area(np.concatenate([[0j], outline])))

    return teeth * (space(whole, tip, teeth) + space(other_whole, other_tip, other) - pocket)


@pytest.mark.parametrize("teeth", [10, 12, 15])
def test_a_pair_of_gears_delivers_what_its_spaces_carry_less_what_comes_back(teeth: int) -> None:
    tip = 0.5 * teeth + 1.0
    exact = delivered(teeth, teeth, tip, tip, internal=False)
    formula = pump.gear_pair_displacement(2e-3 * tip, teeth * 1e-3, 0.01, teeth) * 1e8
    assert formula == pytest.approx(exact, rel=2e-5, abs=0.0)
    without_pitch = math.pi / 2.0 * ((2.0 * tip) ** 2 - teeth**2)
    assert 1.03 < without_pitch / exact < 1.08
    by_module = pump.displacement(1e-3, teeth, 0.01, 2e-3) * 1e8
    assert 0.97 < by_module / exact < 1.0


@pytest.mark.parametrize(("teeth", "ring_teeth"), [(17, 23), (24, 29), (12, 20)])
def test_a_pinion_in_a_ring_gear_delivers_what_its_spaces_carry_less_what_comes_back(
    teeth: int, ring_teeth: int
) -> None:
    tip, ring_tip = 0.5 * teeth + 0.95, 0.5 * ring_teeth - 0.85
    exact = delivered(teeth, ring_teeth, tip, ring_tip, internal=True)
    sizes = (2e-3 * tip, 2e-3 * ring_tip, 0.5e-3 * (ring_teeth - teeth), 0.01, teeth, ring_teeth)
    assert pump.crescent_displacement(*sizes) * 1e8 == pytest.approx(exact, rel=2e-5, abs=0.0)
    wrong = (*sizes[:2], sizes[2] * 1.01, *sizes[3:])
    moved = 2.0 * math.pi * 0.5 * teeth * 0.005 * (ring_teeth - teeth)
    assert (exact - pump.crescent_displacement(*wrong) * 1e8) == pytest.approx(-moved, rel=0.05, abs=0.0)


def test_another_working_angle_matters_little(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = (0.050, 0.042, 0.016, 12)
    usual = pump.gear_pair_displacement(*sizes)
    monkeypatch.setattr(pump, "WORKING_ANGLE", math.radians(27.0))
    assert 1.0 < pump.gear_pair_displacement(*sizes) / usual < 1.011


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (pump.gerotor_displacement, (0.05, 0.06, 0.012, 8), "tip diameter must be above the root diameter"),
        (pump.gear_pair_displacement, (0.04, 0.042, 0.016, 12), "tip diameter must be above the centre distance"),
        (
            pump.crescent_displacement,
            (0.08, 0.09, 0.008, 0.012, 29, 24),
            "ring gear's teeth must be above the pinion's",
        ),
        (pump.crescent_displacement, (0.07, 0.0825, 0.0075, 0.012, 24, 29), "tip diameter must be above its working"),
        (pump.crescent_displacement, (0.0775, 0.09, 0.0075, 0.012, 24, 29), "ring gear must be below its working"),
        (pump.vane_displacement, (0.07, 0.0, 0.018, 13), "eccentricity must be positive"),
        (pump.face_slip, (40e-6, 0.04, 0.048), "outer diameter of the land must be above the inner diameter"),
        (pump.tip_slip, (5e5, -1e-6, 0.012, 0.002, 3, 6e-3, 800.0), "tip clearance"),
    ],
)
def test_dimensions_of_no_pump_are_refused_by_name(function, arguments: tuple, words: str) -> None:
    with pytest.raises(DomainError, match=words):
        function(*arguments)


# --- what slips past the faces


def face_flow(land: float, teeth: int, height: float, sealing: int) -> float:
    """Solve the lubrication equation over one face of a gear; return the flow over that of `pump.face_slip`.

    Polar coordinates with the logarithm of the radius make it Laplace's equation on a rectangle: from the shaft, at no
    pressure, over the ``land`` to the roots, and over the ``height`` of the teeth to their tips, both as logarithms. A
    tooth space is at the pressure of its chamber: delivery over half of the turn, then less from chamber to chamber,
    by 1/``sealing``, down to suction.
    """
    per_tooth = 16
    columns = per_tooth * teeth
    step = 2.0 * math.pi / columns
    deep = round(land / step)
    pressure = np.full((deep + 1 + round(height / step), columns), np.nan)
    pressure[0] = 0.0
    chamber = np.clip(0.5 + (0.25 * teeth - np.abs(np.arange(teeth) - 0.5 * teeth)) / sealing, 0.0, 1.0)
    space = np.arange(columns) % per_tooth < per_tooth // 2
    pressure[deep:, space] = chamber[np.arange(columns) // per_tooth][space]
    gap = pump.face_slip(2.0, math.exp(deep * step), 1.0) / 2.0  # of one face, its gap 1: s³/12 is what flows by it
    return _solved(pressure) / (12.0 * gap)


def _solved(pressure: np.ndarray) -> float:
    """Return what flows into the shaft and into every place at suction pressure."""
    rows, columns = pressure.shape
    number = np.arange(rows * columns).reshape(rows, columns)
    links = [(number, np.roll(number, -1, axis=1)), (number[:-1], number[1:])]
    a, b = (np.concatenate([pair[end].ravel() for pair in links]) for end in (0, 1))
    weight = np.ones(a.size)
    ones = coo_matrix((weight, (a, b)), shape=(number.size,) * 2)
    lap = (ones + ones.T).tocsr()
    degree = np.asarray(lap.sum(axis=1)).ravel()
    flat, known = pressure.ravel(), ~np.isnan(pressure.ravel())
    laplace = coo_matrix((degree, (np.arange(number.size),) * 2), shape=lap.shape).tocsr() - lap
    right = -laplace[~known][:, known] @ flat[known]
    solved = flat.copy()
    solved[~known] = spsolve(laplace[~known][:, ~known].tocsc(), right)
    flow = laplace @ solved
    return float(-flow[known & (flat == 0.0)].sum())


@pytest.mark.parametrize(
    ("ratio", "teeth", "height", "sealing", "low", "high"),
    [
        (1.15, 12, 0.25, 2, 0.85, 0.90),
        (1.15, 24, 0.12, 2, 0.95, 0.98),
        (1.4, 12, 0.25, 2, 1.03, 1.06),
        (1.4, 24, 0.12, 3, 1.00, 1.03),
        (1.7, 24, 0.12, 2, 1.19, 1.23),
        (2.0, 12, 0.25, 3, 1.05, 1.09),
        (2.0, 24, 0.12, 2, 1.28, 1.34),
    ],
)
def test_a_face_with_its_teeth_leaks_nearly_what_its_land_does(
    ratio: float, teeth: int, height: float, sealing: int, low: float, high: float
) -> None:
    assert low < face_flow(math.log(ratio), teeth, height, sealing) < high


@pytest.mark.parametrize(("radius", "clearance"), [(4.0, 0.05), (8.0, 0.15)])
def test_a_round_tip_has_about_the_land_that_the_docstring_says(radius: float, clearance: float) -> None:
    along = np.linspace(-0.6, 0.6, 200_001) * radius
    gap = clearance + radius - np.sqrt(radius**2 - along**2)
    slices = (gap[1:] ** -3.0 + gap[:-1] ** -3.0) / 2.0 * np.diff(along)
    resistance = float(slices.sum())
    assert resistance * clearance**3 == pytest.approx(1.2 * math.sqrt(2.0 * radius * clearance), rel=0.03, abs=0.0)


def test_wider_faces_leak_with_their_cube() -> None:
    assert pump.face_slip(80e-6, 0.066, 0.048) == pytest.approx(
        8 * pump.face_slip(40e-6, 0.066, 0.048), rel=1e-12, abs=0.0
    )


@pytest.mark.parametrize(("clearance", "left"), [(40e-6, (0.95, 1.0)), (110e-6, (0.5, 0.56)), (200e-6, (0.2, 0.22))])
def test_a_tip_leaks_what_its_velocity_allows(clearance: float, left: tuple[float, float]) -> None:
    """The root of friction and entry loss over one of three tips; cold, it is the plane gap."""
    mu, rho, land, width = 5.2e-3, 800.0, 0.002, 0.015
    drop = 890e3 / 3

    def missing(u: float) -> float:
        return 12.0 * mu * land * u / clearance**2 + 0.75 * rho * u * u - drop

    exact = width * clearance * brentq(missing, 0.0, 100.0, xtol=1e-14)
    assert pump.tip_slip(890e3, clearance, width, land, 3, mu, rho) == pytest.approx(exact, rel=1e-9, abs=0.0)
    laminar = width * clearance**3 * drop / (12.0 * mu * land)
    assert left[0] < exact / laminar < left[1]
    cold = pump.tip_slip(890e3, clearance, width, land, 3, 5.0, rho)
    assert cold == pytest.approx(laminar * mu / 5.0, rel=1e-3, abs=0.0)
