"""Draw the charts of the printed report as SVG, distinct in greyscale by dashes and hatches."""

from atleak.report.printed_charts.curves import pump_chart, road_chart

__all__ = ["pump_chart", "road_chart"]
