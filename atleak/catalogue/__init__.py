"""Hold the catalogue: TOML files, and the classes that load and check them."""
