"""A scene: its classes, its TOML, its checks."""
