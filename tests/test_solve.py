"""The solver with chosen solutions, and the mesh's order of convergence."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import renderer
from renderer.readings.photometer import make_meter
from renderer.solving.radiosity_field import distinct_bands
from renderer.transport.factors.exchange import Exchange
from renderer.transport.radiosity.solve import RESIDUAL_TOLERANCE, radiosity

UP = [0.0, 0.0, 1.0]


def closed_exchange(n: int, seed: int) -> Exchange:
    """A random symmetric operator with positive areas as its row sums."""
    random = np.random.default_rng(seed)
    matrix = random.random((n, n))
    matrix = matrix + matrix.T
    np.fill_diagonal(matrix, 0)
    return Exchange(matrix.sum(axis=1), matrix, 0.0, 0.0, (0, 0), 0.0, 0)


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 40), st.integers(0, 10**6), st.floats(0, 0.999))
def test_a_chosen_radiosity_is_found_again(n, seed, largest):
    exchange = closed_exchange(n, seed)
    random = np.random.default_rng(seed + 1)
    rho = random.uniform(0, largest, (n, 4))
    chosen = rho * random.random((n, 4))
    wanted = np.where(rho > 0, chosen / np.where(rho > 0, rho, 1), 0) - exchange.irradiance(chosen)
    got, _ = radiosity(exchange, rho, wanted)
    # The residual is RESIDUAL_TOLERANCE of the right side, which is at most 1 + 1 a patch; it grows by
    # 1/(1 − ρ) and by the spread of the areas (a few).
    np.testing.assert_allclose(got, chosen, atol=50 * RESIDUAL_TOLERANCE * np.sqrt(n) / (1 - largest))


@settings(deadline=None, max_examples=40)
@given(st.integers(2, 40), st.integers(0, 10**6), st.floats(0, 0.999), st.booleans())
def test_a_room_of_one_paint_agrees_with_elimination(n, seed, largest, almost):
    # Some patches are black, as lamps are, some bands dark; `almost`: one patch reflects a little less.
    exchange, random = closed_exchange(n, seed), np.random.default_rng(seed + 1)
    paint = np.append(random.uniform(0, largest, 5), [0.0, largest])
    rho = np.where(random.random(n) < 0.2, 0.0, 1.0)[:, None] * paint
    if almost:
        rho[0] *= 0.999
    common_direct_pattern = random.random(n)
    direct = common_direct_pattern[:, None] * np.append(random.random(6), 0.0)
    got, received = radiosity(exchange, rho, direct, common_direct_pattern=common_direct_pattern)
    factors = exchange.matrix / exchange.areas[:, None]
    wanted = np.stack([np.linalg.solve(np.eye(n) - rho[:, [b]] * factors, (rho * direct)[:, b])
                       for b in range(7)], axis=1)
    # As above.
    np.testing.assert_allclose(got, wanted, atol=50 * RESIDUAL_TOLERANCE * np.sqrt(n) / (1 - largest))
    np.testing.assert_allclose(received, factors @ got, atol=1e-12 / (1 - largest))


class Counting:
    """A matrix that counts how many columns it was multiplied with."""

    def __init__(self, matrix):
        self.matrix, self.columns = matrix, 0

    def __matmul__(self, x):
        self.columns += 1 if x.ndim == 1 else x.shape[1]
        return self.matrix @ x


def test_a_second_paint_needs_no_further_product():
    n, closed = 60, closed_exchange(60, 3)
    matrix = Counting(closed.matrix)
    exchange, random = replace(closed, matrix=matrix), np.random.default_rng(4)
    one_lamp, other = random.random((2, n))
    factors = closed.matrix / closed.areas[:, None]

    def columns(paint: float, common_direct_pattern: np.ndarray, lumens: float = 1.0) -> int:
        before, rho = matrix.columns, np.full((n, 5), paint) * [1, 0.9, 0.5, 0.1, 0]
        direct = lumens * common_direct_pattern[:, None] * np.ones(5)
        got, _ = radiosity(exchange, rho, direct, common_direct_pattern=common_direct_pattern)
        alone, _ = radiosity(
            replace(exchange, matrix=closed.matrix, kept={}),
            rho,
            direct,
            common_direct_pattern=common_direct_pattern,
        )
        np.testing.assert_array_equal(got, alone)  # to the last digit, whatever came before
        wanted = np.stack([np.linalg.solve(np.eye(n) - rho[:, [b]] * factors, (rho * direct)[:, b])
                           for b in range(5)], axis=1)
        np.testing.assert_allclose(got, wanted, atol=50 * RESIDUAL_TOLERANCE * np.sqrt(n) / (1 - paint))
        return matrix.columns - before

    first = columns(0.5, one_lamp)
    assert 2 < first < 48
    assert columns(0.4, one_lamp, 3.0) == 0  # darker, and other lumens
    assert 0 < columns(0.95, one_lamp) < first  # brighter: a few steps more
    assert columns(0.5, one_lamp) == 0
    assert columns(0.5, other) > 2  # light that falls elsewhere


def test_exchanging_bands_exchanges_answers():
    exchange = closed_exchange(12, 3)
    random = np.random.default_rng(0)
    rho, direct = random.random((12, 5)), random.random((12, 5))
    order = [3, 0, 4, 1, 2]
    np.testing.assert_allclose(radiosity(exchange, rho, direct)[0][:, order],
                               radiosity(exchange, rho[:, order], direct[:, order])[0], rtol=1e-9)


def test_bands_that_are_multiples_are_solved_once():
    rho = np.array([[0.2, 0.2, 0.2, 0.5], [0.7, 0.7, 0.7, 0.7]])
    flux = np.array([[1.0, 3.0, 0.0, 2.0]])
    first, index, scale = distinct_bands(rho, flux)
    assert len(first) == 3  # bands 0 and 1; the dark one; the other reflectance
    np.testing.assert_allclose(flux[:, first][:, index] * scale, flux)


def test_a_grey_room_is_one_bands_work_and_a_red_one_is_31():
    grey, red = (renderer.solve(renderer.load(name), bands="31", accuracy=0.1)
                 for name in ("grey_room", "red_room"))
    assert grey.bands_solved == 1
    assert red.bands_solved == 31


@pytest.mark.slow
def test_the_error_falls_faster_than_the_patch_size(room):
    # The mesh alone: no error bar is asked for, which would solve again.
    spots = (([2.0, 2, 0], UP), ([0.01, 0.01, 0], UP))
    readings = np.empty((3, 2, 2))
    for k, rho in enumerate((0.5, 0.9)):
        for i, h in enumerate((0.5, 0.25, 0.125)):
            solution = renderer.solve(room(rho, solver={"patch_size": h}), bands="rgb")
            for j, (spot, normal) in enumerate(spots):
                meter = make_meter(solution.transport, np.array(spot), np.array(normal), "")
                readings[i, j, k] = solution.read_lx(meter).sum()
    steps = np.abs(np.diff(readings, axis=0))
    order = np.log2(steps[0] / steps[1])
    # Differences between successive halvings fall as 2^order. The error bar is the last difference,
    # which is at least the sum of all later ones if the order is 1 or more, also in the corner at 0.9.
    assert (order > 1).all(), order
    # Graded toward edges, the corner converges at nearly second order although light has an infinite
    # slope there; in the open, 5e-5 is left at 0.25 m, where the meter's own elements tell.
    assert (order[1] > 1.5).all(), order
    assert (steps[1, 0] < 1e-4 * readings[2, 0]).all(), steps
