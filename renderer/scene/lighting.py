"""A scene's luminaires from their tables: files, arrays, spectra, and checks of their places in the room."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from renderer.colour.lamps import correlated, illuminant
from renderer.colour.spectrum import Spectrum, read_lamp, spectral_file
from renderer.errors import InputError
from renderer.scene.luminaires.luminaire import Luminaire
from renderer.scene.luminaires.make import make_luminaires
from renderer.scene.photometric.files import read_photometry
from renderer.scene.photometric.record import Photometry
from renderer.scene.room import INSIDE_TOLERANCE, Room, outside, refuse_place_outside
from renderer.scene.schema import LuminaireTable


def resolve_luminaires(tables: list[LuminaireTable], room: Room, path: Path,
                       factor: float = 1.0) -> tuple[list[Luminaire], list[Spectrum], list[str]]:
    """All luminaires, the relative spectra of their lamps, and sentences about faults in their files.

    factor : maintenance factor, the share of new luminaires' lumens

    Raises InputError.
    """
    luminaires, lamps, faults, read = [], [], [], {}
    for index, table in enumerate(tables):
        where = f"{path}: luminaires[{index}]"
        if table.file is not None and table.file not in read:
            read[table.file] = read_photometry(path.parent / table.file, f"{where}.file")
            faults += [f"{table.file}: {fault}." for fault in read[table.file].faults]
        try:
            made = make_luminaires(table, read.get(table.file))
        except ValueError as error:
            raise InputError(f"{where}: {error}.") from None
        faults += _tilted(table, read.get(table.file), made[0])
        extremes = np.concatenate([luminaire.extremes for luminaire in made])
        names = [luminaire.name for luminaire in made for _ in luminaire.extremes]
        for k in np.flatnonzero(outside(extremes, room.shell, INSIDE_TOLERANCE * room.scale))[:1]:
            refuse_place_outside(room, extremes[k], f"{where} {names[k]!r} reaches", "Move or shrink it")
        luminaires += made if factor == 1 else [replace(one, lumens=factor * one.lumens) for one in made]
        lamps += [_lamp(table, path, where)] * len(made)
    return luminaires, lamps, faults


def _tilted(table: LuminaireTable, photometry: Photometry | None, luminaire: Luminaire) -> list[str]:
    """One sentence about the tilt factor of a luminaire, where its file states one other than 1."""
    if photometry is None or photometry.tilt is None:
        return []
    angle, factor = photometry.tilt.angle(luminaire.normal), photometry.tilt.factor(luminaire.normal)
    if factor == 1:
        return []
    what = ("its `flux` already includes that factor" if table.flux is not None
            else f"{luminaire.lumens:.5g} lm are left")
    return [f"luminaires {table.name!r} is tilted by {angle:.3g}°, for which {table.file} states the factor "
            f"{factor:.4g}; {what}."]


def _lamp(table: LuminaireTable, path: Path, where: str) -> Spectrum:
    if table.cct is not None:
        return correlated(table.cct)
    name = "D65" if table.spectrum is None else table.spectrum
    if not spectral_file(name, path.parent):
        return illuminant(name, f"{where}.spectrum")
    return read_lamp(path.parent / name, f"{where}.spectrum")
