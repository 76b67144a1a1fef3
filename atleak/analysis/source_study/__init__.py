"""Run the source study's eight variants through the engine, compare them with the article, and chart them."""

from __future__ import annotations

from atleak.analysis.source_study.variants import (
    VARIANTS,
    OptionRow,
    TemperatureCurve,
    Variant,
    VariantResult,
    compare_options,
    gear_at_most_leakage,
    reaches_digits,
    run_variants,
    sample_log,
    temperature_curves,
    variant_fluid,
    variant_road_test,
)

__all__ = [
    "VARIANTS",
    "OptionRow",
    "TemperatureCurve",
    "Variant",
    "VariantResult",
    "compare_options",
    "gear_at_most_leakage",
    "reaches_digits",
    "run_variants",
    "sample_log",
    "temperature_curves",
    "variant_fluid",
    "variant_road_test",
]
