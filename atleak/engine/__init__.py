"""The engine: clearances, pressures and a fluid give leakage, for one condition or a whole log."""
