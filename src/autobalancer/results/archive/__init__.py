"""An archive: a folder of long runs."""
