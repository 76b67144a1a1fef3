"""Read tables of gauge readings and gauge studies."""
