"""The shaft test: pairs that it calls unobstructed are, and rays decide the others."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from random_rooms import random_scene
from scipy.stats import chi2

import renderer
from renderer.scene.reading import load
from renderer.transport.direct.direct import may_be_shadowed
from renderer.transport.factors import pair_rays
from renderer.transport.factors.exchange import balance
from renderer.transport.factors.hemisphere_rays import cast, count, probed
from renderer.transport.factors.method import HemisphereRays, PairRays
from renderer.transport.factors.pair_rays import change_of_half_samples, contour_exchange, probe_pairs
from renderer.transport.factors.shafts import clusters, doubtful_pairs, may_be_hidden
from renderer.transport.mesh.build import build_mesh
from renderer.transport.radiosity.replicas import departures
from renderer.transport.radiosity.solve import radiosity
from renderer.transport.rays.ray_scene import RayScene
from renderer.transport.rays.sampling import REPLICAS
from renderer.transport.transport import compute_transport

CRATE = {"shape": "box", "position": [1.5, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
TURNED = {"shape": "box", "position": [2.4, 0.4, 0.5], "size": [0.9, 0.5, 0.6], "rotation": 30.0}


def mesh_of(scene, patch_size):
    return build_mesh(scene, patch_size)


def dense(exchange):
    return exchange.matrix if isinstance(exchange.matrix, np.ndarray) else exchange.matrix @ np.eye(
        len(exchange.areas))


def doubtful(mesh, ray_scene):
    found = np.zeros((len(mesh.patches),) * 2, dtype=bool)
    exposed = probed(mesh, ray_scene, (0,)).exposed
    first, second = doubtful_pairs(mesh, np.flatnonzero(exposed), exposed < 1)
    found[first, second] = True
    assert not (found & found.T).any()  # each once
    return found | found.T


def facing(mesh, ray_scene):
    """Pairs of exposed patches, each at least partly in front of the other."""
    reach = np.stack([((mesh.corners - place) @ normal).max(axis=1)
                      for place, normal in zip(mesh.centroid, mesh.normal, strict=True)])
    before = reach > 1e-6 * mesh.scale
    live = probed(mesh, ray_scene, (0,)).exposed > 0
    return before & before.T & live & live[:, None]


@pytest.mark.parametrize("seed", range(1, 13, 4))
def test_nothing_stands_between_patches_in_plain_sight(tmp_path, seed):
    # Rooms with boxes, cylinders, tables and pendants at random places and angles.
    scene = random_scene(seed, tmp_path, crowded=True)
    mesh = mesh_of(scene, 0.12 * scene.room.scale)
    ray_scene = RayScene(mesh)
    plain = np.triu(facing(mesh, ray_scene) & ~doubtful(mesh, ray_scene), 1)
    i, j = np.nonzero(plain)
    assert len(i) > 100
    square = np.random.default_rng(seed).random((8, len(i), 2, 2))
    for here, there in square.transpose(0, 2, 1, 3):
        a = mesh.spread(i, here[:, None])[:, 0]
        b = mesh.spread(j, there[:, None])[:, 0]
        # Only points above each other's horizon exchange light. Rays along a surface cannot be told from rays
        # that meet it.
        ahead = np.minimum(((b - a) * mesh.normal[i]).sum(axis=1), ((a - b) * mesh.normal[j]).sum(axis=1))
        seen = ahead > 1e-4 * mesh.scale
        free = ray_scene.clear(ray_scene.off(a[seen], mesh.normal[i[seen]]), b[seen])
        assert free.all()


def test_only_pairs_across_the_crate_are_doubtful(room):
    mesh = mesh_of(room(objects=[CRATE], luminaires=()), 0.25)
    ray_scene = RayScene(mesh)
    found = doubtful(mesh, ray_scene)
    assert 0.05 < found.sum() / facing(mesh, ray_scene).sum() < 0.35
    low = mesh.centroid[:, 2] < 1
    left, right = (low & (mesh.surface < 6) & (np.abs(mesh.centroid[:, 0] - x) < 1e-9) for x in (0, 4))
    middle = np.abs(mesh.centroid[:, 1] - 2) < 0.4
    # Straight through it, wall to wall; over it, ceiling to walls, nothing stands.
    assert found[np.ix_(left & middle, right & middle)].all()
    assert not found[np.ix_(mesh.surface == 1, (mesh.surface < 6) & (mesh.centroid[:, 2] > 1.3))].any()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e4])
def test_pairs_do_not_depend_on_size_and_place_of_the_room(room, scale):
    def pairs(k):
        crate = {"shape": "box", "position": [1.5 * k, 1.5 * k, 0.0], "size": [k, k, k]}
        mesh = mesh_of(room(size=(4 * k, 4 * k, 3 * k), objects=[crate], luminaires=()), 0.5 * k)
        return doubtful(mesh, RayScene(mesh))

    np.testing.assert_array_equal(pairs(scale), pairs(2.0))


def test_clusters_are_whole_and_small(room):
    mesh = mesh_of(room(objects=[TURNED]), 0.3)
    groups = clusters(mesh, np.arange(len(mesh.patches)))
    assert sorted(groups.patches) == list(range(len(mesh.patches)))
    assert np.diff(groups.starts).max() <= 8
    # Each patch is in its cluster's box: extents along any direction hold all its corners.
    axis = np.random.default_rng(0).normal(size=3)
    low, high = (ends[0] for ends in groups.along(axis[None]))
    own = np.repeat(np.arange(len(groups.flat)), np.diff(groups.starts))
    reach = mesh.corners[groups.patches] @ axis
    assert (reach.min(axis=1) >= low[own] - 1e-12).all()
    assert (reach.max(axis=1) <= high[own] + 1e-12).all()


@pytest.mark.parametrize("objects", [[CRATE], [CRATE, TURNED]])
def test_the_operator_is_closed_reciprocal_positive_and_agrees_with_rays(room, objects):
    mesh = mesh_of(room(objects=objects, luminaires=()), 0.4)
    ray_scene = RayScene(mesh)
    exchange = contour_exchange(mesh, probe_pairs(mesh, ray_scene, 1024, (0,)))
    counted = count(mesh, cast(mesh, ray_scene, 8192, (1,)))
    matrix = exchange.matrix
    assert (matrix >= 0).all()
    np.testing.assert_allclose(matrix, matrix.T, rtol=0, atol=1e-15)
    np.testing.assert_allclose(matrix.sum(axis=1), exchange.areas, rtol=1e-11, atol=1e-15)
    np.testing.assert_allclose(exchange.areas, counted.areas, rtol=1e-12)
    assert len(exchange.unobstructed) > 1000
    member = np.eye(mesh.surface.max() + 1)[mesh.surface]
    ours, theirs = (member.T @ dense(e) @ member for e in (exchange, counted))
    # Between surfaces, 8192 rays from each of 100 patches or more have an error of 1e-3; middles of patches
    # of 0.4 m at 1 to 4 m have one of about (0.4/2)²/12 = 3e-3.
    areas = np.bincount(mesh.surface, exchange.areas)
    np.testing.assert_allclose(ours / areas[:, None], theirs / areas[:, None], atol=5e-3)


@pytest.mark.parametrize("seed", range(1, 13, 4))
def test_nothing_stands_between_a_meter_and_wholly_visible_patches(tmp_path, seed):
    scene = random_scene(seed, tmp_path, crowded=True)
    mesh = mesh_of(scene, 0.12 * scene.room.scale)
    ray_scene, random = RayScene(mesh), np.random.default_rng(seed)
    open_ = probed(mesh, ray_scene, (0,)).exposed
    checked = 0
    # Meters on patches, where they touch what may stand in the way of others, and off them.
    for patch in random.choice(np.flatnonzero(open_ == 1), 12):
        normal = mesh.normal[patch]
        place = ray_scene.off(mesh.centroid[patch], normal) + random.choice([0, 0.05]) * mesh.scale * normal
        away = mesh.centroid - place
        seen = (away @ normal > 0) & ((away * mesh.normal).sum(axis=1) < 0)
        plain = seen & ~may_be_hidden(place, normal, mesh.corners, mesh.obstacles, mesh.scale) & (open_ > 0)
        # A meter inside an object, or a lamp, sees nothing whatever the boxes say.
        if ray_scene.first_hit(place[None], normal[None])[0] < 0:
            continue
        which = np.repeat(np.flatnonzero(plain), 16)
        to = mesh.spread(which, random.random((len(which), 1, 2)))
        to = ray_scene.off(to, mesh.normal[which][:, None])[:, 0]
        ahead = (to - place) @ normal > 0
        assert ray_scene.clear(np.broadcast_to(place, to.shape), to)[ahead].all()
        checked += ahead.sum()
    assert checked > 100


@pytest.mark.parametrize("seed", range(1, 13, 4))
def test_nothing_stands_between_a_lamp_and_fully_lit_patches(tmp_path, seed):
    scene = random_scene(seed, tmp_path, crowded=True)
    mesh = mesh_of(scene, 0.12 * scene.room.scale)
    ray_scene, random = RayScene(mesh), np.random.default_rng(seed)
    open_ = np.flatnonzero(probed(mesh, ray_scene, (0,)).exposed == 1)
    points, normals = mesh.spread(open_, random.random((len(open_), 16, 2))), mesh.normal[open_][:, None]
    points, normals = points.reshape(-1, 3), np.repeat(normals, 16, axis=1).reshape(-1, 3)
    outside = ray_scene.first_hit(ray_scene.off(points, normals), normals) >= 0
    checked = 0
    for luminaire in scene.placement.luminaires:
        lamp = np.array([luminaire.corners.min(axis=0), luminaire.corners.max(axis=0)])
        alone = may_be_shadowed(points[:, None], normals, lamp, mesh.obstacles)
        together = may_be_shadowed(points.reshape(-1, 16, 3), normals[::16], lamp, mesh.obstacles)
        assert (np.repeat(together, 16) | ~alone).all()
        plain = outside & ~alone
        to = np.broadcast_to(luminaire.center, points[plain].shape)
        if luminaire.outline is not None:
            to = luminaire.spread(random.random((len(to), 2)))
        start = ray_scene.off(points[plain], normals[plain])
        lit = ((to - start) * normals[plain]).sum(axis=1) > 0
        if luminaire.forward_only:
            lit &= (start - to) @ luminaire.normal > 0
        assert ray_scene.clear(start, to)[lit].all()
        checked += lit.sum()
    assert checked > 100


def test_half_samples_depart_by_the_error_of_the_whole(room):
    mesh = mesh_of(room(objects=[CRATE, TURNED], luminaires=()), 0.5)
    ray_scene = RayScene(mesh)
    member = np.eye(mesh.surface.max() + 1)[mesh.surface]

    def between(exchange, more=0.0):
        sent = exchange.matrix @ member + exchange.areas[:, None] * more
        return (member.T @ sent)[np.triu_indices(member.shape[1], 1)]

    draws = 24
    sights = [probe_pairs(mesh, ray_scene, 128, (k,)) for k in range(draws)]
    exchanges = [contour_exchange(mesh, sight) for sight in sights]
    truth = np.var([between(exchange) for exchange in exchanges], axis=0, ddof=1)
    halves = [[between(exchange, more) for more in departures(
        exchange, partial(change_of_half_samples, sight, exchange.unobstructed, REPLICAS), member)]
        for exchange, sight in zip(exchanges[::4], sights[::4], strict=True)]
    said = np.var(halves, axis=1, ddof=1).mean(axis=0)
    kept = truth > 1e-3 * truth.max()
    # Both are variances of normal numbers. Their mean ratio over about 30 pairs of surfaces, which depend on
    # each other, is assumed to scatter like that of 5 independent ones.
    low, high = (chi2.ppf(p, 5 * (draws - 1)) / (5 * (draws - 1)) for p in (1e-4, 1 - 1e-4))
    assert low < np.exp(np.log(said[kept] / truth[kept]).mean()) < high


@pytest.mark.parametrize("across", [True, False])
def test_replicas_agree_with_solves_of_each(room, monkeypatch, across):
    monkeypatch.setattr(pair_rays, "MAX_PATCHES_FOR_PAIR_RAYS", 4000 if across else 0)
    solution = renderer.solve(room(0.5, objects=[CRATE, TURNED]), bands="rgb", accuracy=0.1)
    transport, rho = solution.transport, solution.reflectance[solution.transport.mesh.surface]
    exchange, stretch = transport.exchange, transport.stretch
    one = np.eye(len(rho))
    assert isinstance(transport.method, PairRays if across else HemisphereRays)
    more = transport.method.change(transport.mesh, exchange, lambda: transport.hits, one)
    for change, solved in zip(more, solution.by_replica(), strict=True):
        assert np.abs(change - change.T).max() < 1e-12 * exchange.areas.max()
        balanced, _ = balance(dense(exchange) + change, exchange.areas)
        k = solved.replica
        direct = transport.direct + (transport.direct_replicas[k] - transport.direct) / stretch
        sent, _ = radiosity(replace(exchange, matrix=balanced), rho, direct @ solution.flux)
        exact = sent - solution.radiosity
        # What is left out is of second order: smaller again by as much as the replica's rows differ from the
        # whole's, times ρ/(1 − ρ) at most, which is 1 at a reflectance of 0.5.
        found = (solved.radiosity - solution.radiosity) / stretch
        live = exchange.areas > 0
        small = (np.abs(balanced - dense(exchange)).sum(axis=1)[live] / exchange.areas[live]).max()
        assert np.linalg.norm(found - exact) < min(small, 1.0) * np.linalg.norm(exact)


def test_a_room_too_full_or_too_fine_is_left_to_hemispheres(room, monkeypatch):
    scene = room(objects=[CRATE])
    mesh = mesh_of(scene, 0.5)
    assert probe_pairs(mesh, RayScene(mesh), 4, (0,)) is None  # fewer rays than pairs in doubt
    assert probe_pairs(mesh, RayScene(mesh), 1024, (0,)) is not None
    monkeypatch.setattr(pair_rays, "MAX_PATCHES_FOR_PAIR_RAYS", len(mesh.patches) - 1)
    assert probe_pairs(mesh, RayScene(mesh), 1024, (0,)) is None
    assert isinstance(compute_transport(scene, 0.5, 1024, 0).method, HemisphereRays)


def test_a_room_with_nothing_open_has_no_pairs(room):
    mesh = mesh_of(room(objects=[CRATE]), 0.5)
    ray_scene = RayScene(mesh)
    ray_scene.exposed[:] = False
    assert probe_pairs(mesh, ray_scene, 1024, (0,)) is None


def test_both_methods_give_equal_readings(monkeypatch):
    scene = load("furnished_room")
    pairs = renderer.solve(scene, bands="rgb", accuracy=0.02)
    read = pairs.photometers()
    monkeypatch.setattr(pair_rays, "MAX_PATCHES_FOR_PAIR_RAYS", 0)
    hemispheres = renderer.solve(scene, bands="rgb", accuracy=0.02)
    assert isinstance(pairs.transport.method, PairRays)
    assert isinstance(hemispheres.transport.method, HemisphereRays)
    for ours, theirs in zip(read, hemispheres.photometers(), strict=True):
        assert abs(ours.total_lx - theirs.total_lx) <= ours.uncertainty + theirs.uncertainty


@pytest.mark.parametrize(("most", "across"), [(4000, True), (200, False)])
def test_a_mesh_is_held_against_one_of_its_own_kind(room, monkeypatch, most, across):
    # Factors seen from middles err otherwise than those of whole patches: their difference is no mesh error.
    monkeypatch.setattr(pair_rays, "MAX_PATCHES_FOR_PAIR_RAYS", most)
    solution = renderer.solve(room(objects=[CRATE]), bands="rgb", accuracy=0.05)
    other = solution.mesh_sequence.meshes[1].transport
    assert len(other.mesh.patches) <= 200 < len(solution.transport.mesh.patches)
    for transport in (solution.transport, other):
        assert isinstance(transport.method, PairRays if across else HemisphereRays)


@pytest.mark.parametrize("low", [-0.4, 0.0])
def test_a_place_outside_the_room_sees_nothing_in_it(room, low):
    # A crate through a wall has patches half outside; where all is inside, walls are no obstacle at all.
    crate = {"shape": "box", "position": [low, 1.5, 0.0], "size": [1.0, 1.0, 1.0]}
    mesh = mesh_of(room(objects=[crate]), 0.5)
    ray_scene = RayScene(mesh)
    assert (len(mesh.blockers) > 12) == (low < 0)
    inside, outside = np.array([[2.0, 2.0, 2.0]]), np.array([[-0.2, 2.0, 1.001]])
    assert ray_scene.clear(inside, np.array([[0.5, 2.0, 1.001]])).all()
    assert low == 0 or not ray_scene.clear(inside, outside).any()
