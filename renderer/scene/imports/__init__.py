"""Files of other programs, from which `renderer new FILE` makes scene files.

A reader (`formats.READERS`, by the file's suffix) takes a file and gives what it holds as `record.Imported`:
rooms, furniture, lamps, finishes, and what was left out. `write` makes a scene file of that. A new format is
one module here and one line in `formats`.
"""
