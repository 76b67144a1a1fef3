"""What holds for every equation: kinds in and out, NaN, broadcasting, purity, imports and docstrings."""

from __future__ import annotations

import ast
import inspect
import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import atleak.equations
from atleak.common import errors
from atleak.equations import clearance, fluid, gap, orifice, pressure, proportions, pump, vacuum

GAP = (8e5, 0.010, 30e-6, 10.93e-6, 783.0, 0.008)
FACES = (113.1e-6, 58.9e-6, 44.0e-6, 58.9e-6, 44.0e-6)

# Every public equation that gives numbers, with arguments from the middle of its domain.
EQUATIONS: list[tuple[Callable, tuple[float, ...]]] = [
    (gap.annular_flow, (*GAP, 10e-6)),
    (gap.eccentricity_factor, (10e-6, 30e-6)),
    (gap.entry_loss_flow, (*GAP, 1.5, 1.2)),
    (gap.restricted_flow, (8e5, 1e-12, 1e-7)),
    (gap.flow_equal_clearance, (30e-6, 50e-12, 100e-18)),
    (gap.reynolds_number, (8e-7, 0.010, 1e-5)),
    (clearance.diameter_at_reference, (0.010, 21.5e-6, 11.5e-6, 15.0)),
    (clearance.radial_clearance, (0.01006, 0.010)),
    (clearance.worn_clearance, (24e-6, 12e-6)),
    (clearance.wear, (36e-6, 24e-6)),
    (clearance.cube_mean, (6.4e-6, 20e-6)),
    (clearance.effective_clearance, (30e-6, 4.75e-8, 60.0)),
    (clearance.thermal_rate, (0.01006, 0.010, 21.5e-6, 12e-6)),
    (fluid.study_viscosity, (80.0,)),
    (fluid.study_density, (80.0,)),
    (fluid.astm_d341, (80.0, 8.8874, 3.47595)),
    (fluid.dynamic_viscosity, (1e-5, 800.0)),
    (orifice.turbulent_coefficient, (5e-4, 0.62, 797.0)),
    (orifice.transition_pressure, (5e-4, 0.62, 6.2e-6, 797.0, 150.0)),
    (orifice.orifice_flow, (25e3, 6.1e-9, 3587.0)),
    (orifice.laminar_leak, (2e5, 8e-7, 4e5, 5.6e-3, 8.5e-3)),
    (orifice.orifice_leak, (2e5, 5e-6, 4e5, 797.0, 783.0)),
    (orifice.fed_pressure_turbulent, (4.14e5, 6.1e-9, 1.3e-11)),
    (pressure.annulus_area, (0.010, 0.005)),
    (pressure.spring_force, (2000.0, 0.01)),
    (pressure.spring_rate, (80e9, 1e-3, 10.0, 8e-3)),
    (pressure.spring_deflection, (0.03, 0.02)),
    (pressure.control_pressure, (8e5, 20.0, *FACES)),
    (pressure.regulated_pressure, (8e5, 0.5, 1e4, 5e5)),
    (pump.displacement, (0.0045, 12.0, 0.012, 0.0084)),
    (pump.gerotor_displacement, (0.060, 0.050, 0.012, 8.0)),
    (pump.vane_displacement, (0.070, 0.006, 0.018, 13.0)),
    (pump.gear_pair_displacement, (0.050, 0.042, 0.016, 12.0)),
    (pump.crescent_displacement, (0.0775, 0.0825, 0.0075, 0.012, 24.0, 29.0)),
    (pump.face_slip, (40e-6, 0.066, 0.048)),
    (pump.tip_slip, (5e5, 120e-6, 0.012, 0.002, 3.0, 6e-3, 800.0)),
    (pump.slip_coefficient, (2e-13, 1.7e-5)),
    (pump.capacity, (1.7e-5, 40.0, 0.95)),
    (pump.slip_flow, (1.7e-5, 1e-7, 8e5, 8.5e-3)),
    (pump.minimum_speed, (1e-4, 2e-5, 1.7e-5)),
    (vacuum.air_viscosity, (20.0,)),
    (vacuum.gap_air_flow, (6e4, 1e5, 0.0145, 30e-6, 0.005, 20.0, 1.81e-5, 1.2, 1.5)),
    (vacuum.orifice_air_flow, (9e4, 6e4, 6e-7, 20.0)),
]
# These give a pair, words, truth values or reduce an axis; the tests of their own rooms cover them.
OTHERS = {
    clearance.one_sided_moments,
    clearance.seen_of_one_sided,
    gap.obliteration,
    proportions.wilson_interval,
    proportions.newcombe_interval,
    gap.entry_loss_terms,
    gap.restricted_flow_and_slope,
    orifice.orifice_flow_and_slope,
    fluid.astm_d341_coefficients,
    fluid.astm_d341_reliable,
    vacuum.circuit_pressure,
    vacuum.equal_clearance,
    vacuum.stand_flow_area,
}
ROOMS = [clearance, fluid, gap, orifice, pressure, proportions, pump, vacuum]
every_equation = pytest.mark.parametrize(("equation", "arguments"), EQUATIONS, ids=[e.__name__ for e, _ in EQUATIONS])


def public_functions() -> set[Callable]:
    return {
        function
        for room in ROOMS
        for name, function in inspect.getmembers(room, inspect.isfunction)
        if function.__module__ == room.__name__ and not name.startswith("_")
    }


def test_no_equation_is_left_out_here() -> None:
    assert {equation for equation, _ in EQUATIONS} | OTHERS == public_functions()


@every_equation
def test_numbers_give_a_float(equation: Callable, arguments: tuple[float, ...]) -> None:
    plain = equation(*arguments)
    assert type(plain) is float
    assert math.isfinite(plain)
    for kind in (np.float64, np.array):
        again = equation(*[kind(a) for a in arguments])
        assert type(again) is float
        assert again == plain


@every_equation
def test_elements_of_an_array_are_the_scalars(equation: Callable, arguments: tuple[float, ...]) -> None:
    factors = np.array([1.0, 1.0001, 1.0002, 1.0])
    columns = [a * factors if i == 0 else np.full(4, a) for i, a in enumerate(arguments)]
    computed = equation(*columns)
    assert isinstance(computed, np.ndarray)
    assert computed.dtype == np.float64
    for i, value in enumerate(computed):
        assert value == pytest.approx(equation(*[float(column[i]) for column in columns]), rel=4e-16, abs=0.0)


@every_equation
def test_arguments_broadcast_and_lists_are_arrays(equation: Callable, arguments: tuple[float, ...]) -> None:
    first, rest = arguments[0], arguments[1:]
    plain = equation(*arguments)
    assert np.all(equation([first] * 3, *rest) == plain)
    assert equation([first] * 3, *rest).shape == (3,)
    if rest:
        table = equation(np.full((2, 1), first), *rest[:-1], np.full(3, rest[-1]))
        assert table.shape == (2, 3)
        assert table == pytest.approx(np.full((2, 3), plain), rel=1e-15, abs=0.0)
    assert equation(np.array([]), *rest).shape == (0,)


@every_equation
def test_nan_stays_nan_and_spoils_nothing_else(equation: Callable, arguments: tuple[float, ...]) -> None:
    plain = equation(*arguments)
    for i in range(len(arguments)):
        given = list(arguments)
        given[i] = math.nan
        assert math.isnan(equation(*given))
        given[i] = np.array([arguments[i], math.nan, arguments[i]])
        computed = equation(*given)
        assert np.isnan(computed).tolist() == [False, True, False]
        assert computed[[0, 2]] == pytest.approx([plain, plain], rel=4e-16, abs=0.0)


@every_equation
def test_arguments_are_left_alone(equation: Callable, arguments: tuple[float, ...]) -> None:
    columns = [np.full(5, a) for a in arguments]
    for column in columns:
        column.flags.writeable = False
    computed = equation(*columns)
    assert not any(np.shares_memory(computed, column) for column in columns)
    assert all(np.all(column == a) for column, a in zip(columns, arguments, strict=True))


@pytest.mark.parametrize("function", sorted(public_functions(), key=lambda f: f.__name__), ids=lambda f: f.__name__)
def test_docstrings_say_what_they_must(function: Callable) -> None:
    text = inspect.getdoc(function) or ""
    for section in ("Parameters", "Returns", "References", "Examples"):
        assert re.search(rf"^{section}\n-+$", text, re.MULTILINE), section
    returns = text.split("Returns\n-------\n")[1].split("\n\n")[0]
    assert "bool" in returns or "str" in returns or re.search(r"\[[^\]]+\]", returns)
    parameters = text.split("Parameters\n----------\n")[1].split("\n\nReturns")[0]
    for name in inspect.signature(function).parameters:
        assert re.search(rf"(^|, ){name}(,| :)", parameters, re.MULTILINE), name
    if function is not fluid.astm_d341_reliable:
        assert "DomainError" in text


PACKAGE = Path(atleak.equations.__file__).parent


def test_what_equations_expect_is_said_in_the_program_s_words() -> None:
    """`refuse(name, value, bad, expected, …)` and ``DomainError(name, expected, …)``."""
    expected = set()
    for file in PACKAGE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            place = {"refuse": 3, "DomainError": 1}.get(getattr(getattr(node, "func", None), "id", ""))
            if place is not None and isinstance(node.args[place], ast.Constant):
                expected.add(node.args[place].value)
    assert len(expected) > 15
    assert expected <= set(errors._OF_EQUATIONS)


# --- the product calls its own equations


def public_names() -> set[str]:
    """``module.function`` of every public function of the package."""
    return {
        f"{file.stem}.{node.name}"
        for file in PACKAGE.glob("*.py")
        if not file.stem.startswith("_")
        for node in ast.parse(file.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
    }


def equations_used_in(source: str) -> set[str]:
    """``module.function`` of every equation that a file refers to, beyond importing it."""
    tree = ast.parse(source)
    modules: dict[str, str] = {}  # name in the file → module of equations
    functions: dict[str, str] = {}  # name in the file → module.function
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module == "atleak.equations":
            modules |= {alias.asname or alias.name: alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("atleak.equations."):
            module = (node.module or "").rpartition(".")[2]
            functions |= {alias.asname or alias.name: f"{module}.{alias.name}" for alias in node.names}
    used = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in modules:
            used.add(f"{modules[node.value.id]}.{node.attr}")
        elif isinstance(node, ast.Name) and node.id in functions:
            used.add(functions[node.id])
    return used


def test_uses_of_equations_are_seen_under_any_name() -> None:
    source = (
        "from atleak.equations import gap as g, pump\n"
        "from atleak.equations.clearance import wear as w, thermal_rate\n"
        "g.annular_flow(1)\npump.capacity\nw(1)\nthermal.rate\n"
    )
    assert equations_used_in(source) == {"gap.annular_flow", "pump.capacity", "clearance.wear"}


def test_the_product_calls_every_equation() -> None:
    used: set[str] = set()
    for file in sorted(PACKAGE.parent.rglob("*.py")):
        if PACKAGE not in file.parents:
            used |= equations_used_in(file.read_text(encoding="utf-8"))
    assert public_names() <= used, "only tests call these: call them where the product computes the same, or move them"
