"""The pages that `generate` writes, one module a subject."""
