"""Factors from SI to the units people read, in reports, figures and records alike: ``metres * UM`` are micrometres.

Units in capitals with a bracket behind them are that unit in SI.
"""

from __future__ import annotations

DM3_MIN = 6.0e4  # m³/s → dm³/min
MM3_S = 1.0e9  # m³/s → mm³/s
KPA = 1.0e-3
MPA_S = 1.0e3  # Pa·s → mPa·s
MM = 1.0e3
UM = 1.0e6
MM2_S = 1.0e6  # m²/s → mm²/s
G_CM3 = 1.0e-3  # kg/m³ → g/cm³
RPM = 60.0  # 1/s → 1/min
PERCENT = 100.0
INCH = 0.0254  # [m]
MILE = 1609.344  # [m]
PSI = 4.4482216152605 / INCH**2  # [Pa], pound-force on a square inch: 6894.757293168361
QUART = 0.946352946e-3  # [m³], US liquid quart: 57.75 in³
