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
from atleak.equations import clearance, fluid, gap, pressure, pump

GAP = (8e5, 0.010, 30e-6, 10.93e-6, 783.0, 0.008)
FACES = (113.1e-6, 58.9e-6, 44.0e-6, 58.9e-6, 44.0e-6)

# Every public equation that gives numbers, with arguments from the middle of its domain.
EQUATIONS: list[tuple[Callable, tuple[float, ...]]] = [
    (gap.annular_flow, (*GAP, 10e-6)),
    (gap.annular_flow_compressible, (8e5, 0.010, 30e-6, 8.5e-3, 0.008, 784.0, 783.0)),
    (gap.eccentricity_factor, (10e-6, 30e-6)),
    (gap.exact_annulus_flow, (8e5, 0.010, 0.01006, 8.5e-3, 0.008)),
    (gap.entry_loss_flow, (*GAP, 1.5)),
    (gap.reynolds_number, (8e-7, 0.010, 1e-5)),
    (gap.taper_cube, (20e-6, 40e-6)),
    (gap.oval_cube, (30e-6, 10e-6)),
    (clearance.radial_clearance, (0.01006, 0.010)),
    (clearance.worn_clearance, (24e-6, 12e-6)),
    (clearance.wear, (36e-6, 24e-6)),
    (clearance.effective_clearance, (30e-6, 0.01006, 0.010, 21.5e-6, 12e-6, 60.0, 60.0)),
    (clearance.thermal_rate, (0.01006, 0.010, 21.5e-6, 12e-6)),
    (fluid.study_viscosity, (80.0,)),
    (fluid.study_density, (80.0,)),
    (fluid.astm_d341, (80.0, 8.8874, 3.47595)),
    (fluid.dynamic_viscosity, (1e-5, 800.0)),
    (pressure.annulus_area, (0.010, 0.005)),
    (pressure.pressure_force, (8e5, 5e-5)),
    (pressure.spring_force, (2000.0, 0.01)),
    (pressure.spring_rate, (80e9, 1e-3, 10.0, 8e-3)),
    (pressure.spring_deflection, (0.03, 0.02)),
    (pressure.spool_balance, (3e5, 8e5, 20.0, *FACES)),
    (pressure.control_pressure, (8e5, 20.0, *FACES)),
    (pressure.modulated_pressure, (8e5, 0.5, 5e5)),
    (pump.displacement, (0.0045, 12.0, 0.012, 0.0084)),
    (pump.capacity, (1.7e-5, 40.0, 0.95)),
    (pump.wilson_efficiency, (1e-7, 8e5, 8.5e-3, 40.0)),
    (pump.slip_flow, (1.7e-5, 1e-7, 8e5, 8.5e-3)),
    (pump.minimum_speed, (1e-4, 2e-5, 1.7e-5)),
]
# These give a pair, words, truth values or reduce an axis; the tests of their own rooms cover them.
OTHERS = {
    gap.circumferential_cube,
    gap.axial_cube,
    gap.obliteration,
    fluid.astm_d341_coefficients,
    fluid.astm_d341_reliable,
}
ROOMS = [clearance, fluid, gap, pressure, pump]
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


def test_equations_import_only_numpy_and_mathematics() -> None:
    allowed = {"__future__", "collections", "math", "numpy", "statistics", "typing"}
    files = sorted(Path(atleak.equations.__file__).parent.glob("**/*.py"))
    assert {f.name for f in files} >= {"gap.py", "clearance.py", "fluid.py", "pressure.py", "pump.py"}
    for file in files:
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                modules = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0, file.name
                modules = [node.module or ""]
            else:
                continue
            for module in modules:
                own = module == "atleak.errors" or module.split(".")[:2] == ["atleak", "equations"]
                assert own or module.split(".")[0] in allowed, f"{file.name} imports {module}"
