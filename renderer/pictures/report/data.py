"""The data from which a report's page computes pictures and readings.

A pixel is a sparse row of weights on direct light by surface and luminaire, and on vertices. It does not
depend on materials and bands. A solution is the irradiance of vertices. The page stores pixels and solutions
separately, so that rooms of one shape share pixels and each pixel has a whole spectrum.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from renderer.pictures.camera import View
from renderer.pictures.report.bars import patch_bars, shadow_bars
from renderer.pictures.report.pack import Pack
from renderer.readings.uncertainty import student
from renderer.solving.solution import Solution
from renderer.transport.sensors import direct_on
from renderer.transport.transport import Transport


@dataclass(frozen=True)
class Lamps:
    """Groups of luminaires with equal spectra in every room of the page: a hundred equal panels are one
    column.

    first : (n_groups,) one luminaire of each group
    power : (n_luminaires,) power of each luminaire for unit power of its group
    group : (n_luminaires,) number of each luminaire's group
    """

    first: np.ndarray
    power: np.ndarray
    group: np.ndarray

    def joined(self, per_lumen) -> np.ndarray:
        """Sums over groups (n, n_groups) of columns of luminaires (n, n_luminaires)."""
        weights = sparse.csr_array((self.power, (np.arange(len(self.group)), self.group)),
                                   shape=(len(self.group), len(self.first)))
        return per_lumen @ weights

    def flux(self, solution: Solution) -> np.ndarray:
        """Flux (n_groups, n_bands) of each group at power 1."""
        power = self.power[self.first]
        return solution.flux[self.first] / np.where(power > 0, power, 1.0)[:, None]


def lamps_of(solutions: list[Solution]) -> Lamps:
    """The luminaires of solutions on one transport, grouped where their spectra are equal in all
    solutions."""
    flux = np.hstack([solution.flux for solution in solutions])
    power = np.linalg.norm(flux, axis=1)
    shape = np.round(flux / np.where(power > 0, power, 1.0)[:, None], 12)
    _, first, group = np.unique(shape, axis=0, return_index=True, return_inverse=True)
    return Lamps(first, power, group.ravel())


def geometry_data(transport: Transport, lamps: Lamps, pack: Pack) -> dict:
    """The patches of a room and their direct illuminance."""
    mesh = transport.mesh
    replicas = len(transport.direct_replicas)
    spread = (student(replicas) * transport.direct_replicas.std(axis=0, ddof=1) / np.sqrt(replicas)
              if replicas > 1 else np.zeros(transport.direct.shape))
    return {
        "middle": mesh.middle.tolist(), "scale": mesh.scale,
        "vertices": pack.reals(mesh.vertices - mesh.middle),
        "patches": pack.whole(mesh.patches), "surface": pack.whole(mesh.surface),
        "vertexSurface": pack.whole(mesh.vertex_surface),
        "shown": pack.whole(transport.exchange.areas > 0),
        "lamp": pack.whole(~transport.reflecting),
        "light": _columns(lamps.joined(transport.direct), pack),
        "lightBars": _columns(np.sqrt(_squares(lamps, spread)), pack),
        "shining": _sparse(lamps.joined(_exitance(transport)), pack),
        "groups": len(lamps.first), "fine": _fine(transport, lamps, pack),
        "luminaires": [{"name": lum.name, "center": (lum.center - mesh.middle).tolist(),
                        "outline": None if lum.is_point else (lum.outline - mesh.middle).tolist()}
                       for lum in transport.luminaires],
    }


def _fine(transport: Transport, lamps: Lamps, pack: Pack) -> dict:
    """Direct illuminance per lumen of each group at (steps + 1)² places on each exposed patch (three on a
    triangle), for the view in three dimensions.

    There are at most eight steps and about 60,000 places in total, each with 64 shadow rays.
    """
    mesh = transport.mesh
    shown = np.flatnonzero(transport.exchange.areas > 0)
    quads, triangles = (shown[mesh.triangular[shown] == flag] for flag in (False, True))
    steps = int(np.clip(np.sqrt(60_000 / max(1, len(quads))) - 1, 1, 8))
    across = np.arange(steps + 1) / steps
    t, s = np.meshgrid(across, across, indexing="ij")
    patch = np.concatenate([np.repeat(quads, s.size), np.repeat(triangles, 3)])
    st = np.vstack([np.tile(np.column_stack([s.ravel(), t.ravel()]), (len(quads), 1)),
                    np.tile([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], (len(triangles), 1))])
    st += 1e-3 * (mesh.middle_st[patch] - st)  # inside the patch: an edge has no unique illuminance
    light = direct_on(transport, patch, *st.T, 3, 64)[0]
    return {"steps": steps, "light": _columns(lamps.joined(light), pack)}


def _exitance(transport: Transport) -> sparse.csr_array:
    """Exitance (n_patches, n_luminaires) per lumen [m⁻²] of the fronts of luminaires' faces."""
    mesh = transport.mesh
    found = sparse.lil_array((len(mesh.patches), len(transport.luminaires)))
    for surface, k in transport.faces:
        front = (mesh.surface == surface) & (mesh.normal @ transport.luminaires[k].normal > 0)
        found[np.flatnonzero(front), k] = 1 / transport.luminaires[k].area
    return found.tocsr()


def view_data(view: View, lamps: Lamps, pack: Pack) -> dict:
    """The sensors of a camera's pixels."""
    edge = np.flatnonzero(view.edge)
    camera, groups = view.camera, len(lamps.first)
    n_luminaires = view.light.shape[1]
    direct = view.sensor.direct[edge].tocoo()
    surface, luminaire = np.divmod(direct.col, max(1, n_luminaires))
    joined = sparse.coo_array(
        (direct.data * lamps.power[luminaire], (direct.row, surface * groups + lamps.group[luminaire])),
        shape=(len(edge), view.share.shape[1] * groups)).tocsr()
    middle = view.transport.mesh.middle
    return {
        "width": camera.width, "height": camera.height, "eye": (view.eye - middle).tolist(),
        "position": (camera.position - middle).tolist(), "axes": camera.axes.tolist(),
        "spread": camera.spread,
        "patch": pack.whole(np.maximum(view.patch + 1, 0)),
        "light": _columns(lamps.joined(view.light), pack),
        "bars": _sparse(sparse.csr_array(_squares(lamps, shadow_bars(view))).sqrt(), pack),
        "shining": _sparse(lamps.joined(view.emitted), pack),
        "edge": pack.whole(edge), "edgeDirect": _sparse(joined, pack),
        "edgeIndirect": _sparse(view.sensor.indirect[edge], pack),
    }


def solution_data(solution: Solution, lamps: Lamps, pack: Pack) -> dict:
    """The irradiance of vertices by band, and its weights for luminance and illuminance."""
    bands = solution.bands
    spectral = bands.edges is not None
    return {
        "xyz": bands.xyz.tolist(), "reflectance": solution.reflectance.tolist(),
        "flux": lamps.flux(solution).tolist(),
        "received": pack.curves(np.maximum(solution.vertex_irradiance, 0.0)),
        "wavelengths": bands.centres.tolist() if spectral else None,
        "widths": bands.widths.tolist() if spectral else None,
        "lamps": solution.flux.sum(axis=0).tolist(),
    }


def bars_data(solution: Solution, pack: Pack) -> dict:
    """Error bars [lx] of the indirect illuminance on each patch."""
    mesh, sampling = patch_bars(solution)
    return {"mesh": pack.logarithms(mesh), "sampling": pack.logarithms(sampling)}


def _squares(lamps: Lamps, half_widths):
    """Squares of the errors of groups (n, n_groups), from independent errors of luminaires (n,
    n_luminaires)."""
    return lamps.joined(half_widths**2 * lamps.power)


def _columns(values: np.ndarray, pack: Pack) -> list[dict]:
    return [pack.logarithms(column) for column in np.asarray(values).T]


def _sparse(rows, pack: Pack) -> dict:
    """A sparse matrix as the numbers of entries in its rows, their columns and their values."""
    rows = sparse.csr_array(rows)
    rows.sort_indices()
    return {"counts": pack.whole(np.diff(rows.indptr)), "columns": pack.whole(rows.indices),
            "values": pack.logarithms(rows.data)}
