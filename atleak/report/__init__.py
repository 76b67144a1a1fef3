"""Turn a diagnosis into bytes and records. Renderers compute nothing: every number comes from the result."""
