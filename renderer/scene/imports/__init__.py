"""Files of other programs, from which `renderer new FILE` makes scene files.

A reader (`formats.READERS`, by the file's suffix) returns the rooms, furniture, lamps and finishes of a file,
and notes on what was left out, as `record.Imported`. `write` makes a scene file of that. A new format is
one module here and one line in `formats`.
"""
