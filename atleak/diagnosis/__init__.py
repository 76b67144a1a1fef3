"""Judge a unit: rules, uncertainty, gauges and the result that keeps its inputs."""
