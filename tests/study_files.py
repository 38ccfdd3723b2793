"""Studies for tests, and their tables."""

import csv

from renderer.studies.sweep import read_study

STUDY = """
scenes = [{scenes}]
[vary]
"materials.grey.reflectance" = {values}
"luminaires.0.flux" = [1000.0, 2000.0]
"""
VALUES = [0.05 * k for k in range(1, 9)]


def study(folder, values=VALUES, scenes='"grey_room"', accuracy=0.2, text=None):
    path = folder / "paints.toml"
    path.write_text(text or STUDY.format(values=values, scenes=scenes))
    return read_study(path, accuracy, "rgb", None)


def rows(files):
    with files[0].open() as file:
        return list(csv.DictReader(file))


def settings(table):
    return [(float(r["materials.grey.reflectance"]), float(r["luminaires.0.flux"])) for r in table]


ROOM = """
[room]
size = [4, 4, 3]
floor = "paint"
walls = "paint"
ceiling = "paint"
[materials.paint]
spectrum = "p1.csv"
[[luminaires]]
shape = "point"
center = [2, 2, 2]
flux = {flux}
[[photometers]]
position = [1, 1, 0]
"""
PAINTS = 'scenes = {scenes}\n[vary]\n"materials.paint.spectrum" = ["p1.csv", "p2.csv"]'
