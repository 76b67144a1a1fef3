"""Results → plotly figures; nothing is computed here, and nothing is shown."""
