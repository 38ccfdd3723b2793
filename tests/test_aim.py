"""Aim of rays at luminaires: few rays must agree with many, at any distance."""

import numpy as np
import pytest

import renderer
from renderer.radiometry.polygons import exchanged, polygon_factors
from renderer.transport.direct.direct import direct_at, visible_share
from renderer.transport.mesh.build import build_mesh
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import Nets

FACING = {"center": [2.0, 2.0, 3.0], "normal": [0, 0, -1], "luminance": 1000.0}
RECTANGLE = {"shape": "rectangle", "size": [1.2, 0.8], **FACING}
DISC = {"shape": "disc", "diameter": 1.2, **FACING}
RAYS, PLACES = 256, 64


@pytest.mark.parametrize("lamp", [RECTANGLE, DISC])
@pytest.mark.parametrize("below", [0.003, 0.1, 1.0, 2.9])
def test_points_represent_areas_whose_light_sums_to_the_faces(room, lamp, below):
    luminaire = room(luminaires=[lamp]).luminaires[0]
    random = np.random.default_rng(0)
    places = np.column_stack([2.0 + random.uniform(-0.3, 0.3, (PLACES, 2)), np.full(PLACES, 3.0 - below)])
    normals = np.column_stack([random.normal(size=(PLACES, 2)), np.full(PLACES, 1.0)])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    square = Nets(RAYS, 2, (0,)).draw(0, PLACES)
    truth = polygon_factors(places, normals, np.repeat(luminaire.outline[None], PLACES, axis=0))

    def error(targets, stands):
        brought = stands * exchanged(places[:, None], normals[:, None], targets, luminaire.normal)
        return np.abs(brought.mean(axis=1) / np.pi / truth - 1)

    # Nets have a smaller error than independent points, whose error is the standard deviation of their
    # weights over √n; a weight is at most about four times its mean.
    aside = error(*luminaire.aimed(places[:, None], square))
    assert aside.max() < 4 / np.sqrt(RAYS)
    assert np.sqrt((aside**2).mean()) < 1 / np.sqrt(RAYS)
    if below < 0.01:
        assert np.median(error(luminaire.spread(square), luminaire.area)) > 0.5


def test_eight_rays_between_blades_under_a_large_face_are_right_in_the_mean(room):
    """A blade sees a strip of the lamp past the next blade, from which most of its light comes. Of eight
    evenly spread points at most one is on the strip: their mean would be 0.16 instead of 0.44."""
    blade = {"shape": "box", "position": [1.90, 0.2, 2.7], "size": [0.02, 3.6, 0.2]}
    scene = room(luminaires=[{**RECTANGLE, "size": [3.6, 3.6]}], objects=[blade])
    luminaire = scene.luminaires[0]
    ray_scene = RayScene(build_mesh(scene, 0.5))
    point, normal = np.array([2.05, 2.0, 2.8]), np.array([-1.0, 0.0, 0.0])
    # Past the blade's upper edge the face is seen from where the line from the point over that edge ends.
    seen = luminaire.outline.copy()
    seen[:, 0] = seen[:, 0].clip(min=1.92 - (2.05 - 1.92) * (3.0 - 2.9) / (2.9 - 2.8))
    truth, whole = (polygon_factors(point[None], normal[None], polygon[None])[0]
                    for polygon in (seen, luminaire.outline))
    points, normals = (np.repeat(each[None], 4000, axis=0) for each in (point, normal))
    share = visible_share(points, normals, luminaire, ray_scene, 8, (0,), 1)[0]
    error = share.std() / np.sqrt(len(share))
    # A quotient of means is biased by the variance of what a point brings over n, here a hundredth.
    assert share.mean() == pytest.approx(truth / whole, abs=3 * error + 0.01)


def test_a_louvres_blades_absorb_the_share_of_rays_that_meet_them(room):
    """Nine blades 0.1 m under a face of 1.2 m, in a black room, against 200,000 rays from the lamp, traced
    here from box to box."""
    low = np.array([[1.4, 1.4 + 1.2 * (k + 0.5) / 9 - 0.005, 2.7] for k in range(9)])
    size = np.array([1.2, 0.01, 0.2])
    blades = [{"shape": "box", "position": at.tolist(), "size": size.tolist()} for at in low]
    scene = room(0.0, luminaires=[{**RECTANGLE, "size": [1.2, 1.2]}], objects=blades)
    random, n = np.random.default_rng(0), 200_000
    start = np.column_stack([2.0 + random.uniform(-0.6, 0.6, (n, 2)), np.full(n, 3.0)])
    radius, turn = np.sqrt(random.random(n)), 2 * np.pi * random.random(n)
    along = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), -np.sqrt(1 - radius**2)])
    met = np.zeros(n, dtype=bool)
    for corner in low:
        first, last = (corner - start) / along, (corner + size - start) / along
        met |= np.minimum(first, last).max(axis=1) < np.maximum(first, last).min(axis=1)
    floor = (np.abs(start + along * (3.0 / -along[:, 2:]) - 2.0)[:, :2] < 2.0).all(axis=1) & ~met
    transport = renderer.solve(scene, "rgb", 0.05).transport
    brought = transport.exchange.areas * transport.direct[:, 0]
    share = np.bincount(transport.mesh.surface, brought, transport.n_surfaces)
    names = np.array(scene.surface_names)
    # Three standard deviations of the rays' count, and as much of the patches' own.
    allowed = 3 * np.sqrt(0.25 / n) * np.sqrt(2)
    assert share[names == "floor"].sum() == pytest.approx(floor.mean(), abs=allowed)
    assert share[-10:-1].sum() == pytest.approx(met.mean(), abs=allowed)
    assert np.abs(transport.lost).max() < 0.005


def test_luminaires_that_are_alike_are_shadowed_like_each_of_them_alone(room, tmp_path):
    """Six panels of an array, the same panel turned and a larger one, discs, points and a photometric file
    at two places and turned, over a crate."""
    steep = [f"{x:g}" for x in range(0, 91, 10)]
    lines = ["IESNA:LM-63-2002", "[TEST] synthetic", "TILT=NONE", "1 -1 1 10 1 1 2 0.3 0.9 0", "1 1 30",
             " ".join(steep), "0", " ".join(f"{1000 - 10 * float(x):g}" for x in steep), ""]
    (tmp_path / "lamp.ies").write_text("\n".join(lines), encoding="ascii")
    panel = {"shape": "rectangle", "size": [0.6, 0.3], "normal": [0, 0, -1], "flux": 1000}
    disc, point = ({"shape": shape, "normal": [0, 0, -1], "flux": 700, key: value} for shape, key, value in (
        ("disc", "diameter", 0.4), ("point", "distribution", "lambertian")))
    measured = {"shape": "ies", "file": str(tmp_path / "lamp.ies")}
    lamps = [{**panel, "center": [2.0, 2.0, 2.9], "array": [3, 2], "spacing": [1.2, 2.0]},
             {**panel, "center": [2.0, 2.0, 2.4], "normal": [0.3, 0, -1]},
             {**panel, "center": [3.2, 2.0, 2.6], "size": [0.9, 0.45]},
             *({**lamp, "center": [x, 2.4, 2.7]} for x in (0.7, 2.9) for lamp in (disc, point, measured)),
             {**measured, "center": [1.5, 1.5, 2.5], "up": [1, 1, 0]}]
    scene = room(luminaires=lamps, objects=[{"shape": "box", "position": [1.2, 1.2, 0.3],
                                             "size": [1.4, 1.2, 0.9]}])
    ray_scene, luminaires = RayScene(build_mesh(scene, 0.5)), scene.placement.luminaires
    random = np.random.default_rng(0)
    points = np.column_stack([random.uniform(0.1, 3.9, (60, 2)), random.uniform(0.01, 0.25, 60)])
    normals, rays = np.tile([0.0, 0.0, 1.0], (60, 1)), 1024
    together, *alone = (direct_at(points, normals, some, ray_scene, (0, 0), rays)[0]
                        for some in (luminaires, *([lum] for lum in luminaires)))
    alone = np.concatenate(alone, axis=1)
    bare = direct_at(points, normals, luminaires, None, (0, 0))[0]
    shadowed = (alone > 0.01 * bare) & (alone < 0.99 * bare)
    assert shadowed.any(axis=0).sum() > 6  # of 16 luminaires have a penumbra at some point
    # The visible share of a net's points errs by about the power ¾ of their number.
    assert np.abs(together - alone).max(where=bare > 0, initial=0) < 4 * rays**-0.75 * bare.max()
    assert (together[alone == 0] <= 4 * rays**-0.75 * bare[alone == 0]).all()
