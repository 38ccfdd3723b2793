"""A solution as an xarray Dataset with one row for each patch."""

import numpy as np

from renderer.solving.solution import Solution


def dataset(solution: Solution):
    """Light on every exposed patch, as an xarray.Dataset with units as attributes.

    Dimensions: patch, and wavelength (the middle of each band [nm]), or band where bands are not intervals of
    wavelength. By band: irradiance, direct_irradiance and radiosity [W m⁻² nm⁻¹, or lm m⁻² where the bands
    are weighted integrals], reflectance [1]. By patch: illuminance [lx], luminance [cd m⁻²], area [m²].
    Coordinates of a patch: surface, and x, y, z of its middle [m]. Raises ImportError where xarray is not
    installed.
    """
    try:
        import xarray
    except ImportError:
        raise ImportError("to_xarray needs xarray, which is not installed. Install it with: "
                          "pip install 'spectral-radiosity[notebook]'") from None
    scene, bands, mesh = solution.scene, solution.bands, solution.transport.mesh
    areas = solution.transport.exchange.areas
    shown = np.flatnonzero(areas > 0)
    surface, luminous = mesh.surface[shown], bands.luminous
    irradiance, direct, radiosity = (values[shown] for values in (
        solution.irradiance, solution.direct_irradiance, solution.radiosity))
    by_band, axis, unit, per_nm = ("patch", "band"), _bands(solution), "lm m-2", 1.0
    if bands.edges is not None:
        by_band, unit, per_nm = ("patch", "wavelength"), "W m-2 nm-1", bands.widths / bands.watts
        axis = {"wavelength": ("wavelength", bands.centres, _said("wavelength, middle of the band", "nm")),
                "band_width": ("wavelength", bands.widths, _said("width of the band", "nm"))}
    middle = dict(zip("xyz", mesh.centroid[shown].T, strict=True))
    return xarray.Dataset(
        {"irradiance": (by_band, irradiance / per_nm, _said("irradiance, direct and indirect", unit)),
         "direct_irradiance": (by_band, direct / per_nm, _said("irradiance straight from the lamps", unit)),
         "radiosity": (by_band, radiosity / per_nm, _said("radiosity, all light that is reflected", unit)),
         "reflectance": (by_band, solution.reflectance[surface], _said("diffuse reflectance", "1")),
         "illuminance": ("patch", irradiance @ luminous, _said("illuminance, direct and indirect", "lx")),
         "luminance": ("patch", radiosity @ luminous / np.pi, _said("luminance, reflected light", "cd m-2")),
         "area": ("patch", areas[shown], _said("area that is not covered", "m2"))},
        {"patch": ("patch", shown, {"long_name": "number of the patch in the mesh"}), **axis,
         "surface": ("patch", np.array(scene.surface_names)[surface],
                     {"long_name": "surface, or lamp's face"}),
         **{name: ("patch", values, _said(f"{name} of the patch's middle", "m"))
            for name, values in middle.items()}},
        {"title": scene.title, "bands": bands.name, "seed": solution.transport.seed,
         "patch_size_m": solution.plan.patch_size, "rays_per_patch": solution.plan.rays})


def _bands(solution: Solution) -> dict:
    """Coordinates of bands that are not intervals of wavelength: names of channels, or placed nodes with
    their wavelengths [nm]."""
    bands = solution.bands
    if bands.nodes is not None:
        numbers = np.arange(1, len(bands.nodes) + 1)
        return {"band": ("band", numbers, {"long_name": "number of the placed node"}),
                "node": ("band", bands.nodes, _said("wavelength of the node", "nm"))}
    return {"band": ("band", list("RGB"), {"long_name": f"channel of {bands.name}"})}


def _said(long_name: str, units: str) -> dict[str, str]:
    return {"long_name": long_name, "units": units}
