"""What commands share: options, files to write, tables, progress, notes."""
