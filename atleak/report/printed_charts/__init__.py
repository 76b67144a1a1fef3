"""Draw the charts of the printed report as SVG, distinct in greyscale by dashes and hatches."""

from atleak.report.printed_charts.bars import TwoBars, pressures_chart, two_visits_chart
from atleak.report.printed_charts.curves import pump_chart, road_chart

__all__ = ["TwoBars", "pressures_chart", "pump_chart", "road_chart", "two_visits_chart"]
