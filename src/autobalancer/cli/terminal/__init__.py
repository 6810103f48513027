"""What all commands share: options, quantities, tables, files, messages."""
