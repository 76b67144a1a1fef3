"""Turn results into plotly figures; nothing is computed here, and nothing is shown."""
