"""Six placed nodes: accuracy for paints, lamps and rooms, and quantities that they do not give."""

import json

import numpy as np
import pytest

from renderer.colour.bands import band_set
from renderer.colour.lamps import band_flux, illuminant, power_at_1_nm
from renderer.colour.nodes import (
    FIRST_NODES,
    GRID,
    luminous_at_1_nm,
    node_weights,
    nodes_for_lamps,
    place_nodes,
)
from renderer.colour.spectrum import Spectrum
from renderer.colour.tables import cie_1931

LAMPS = ("D65", "A", "FL2", "FL11", "LED-B3", "HP1")
POINT = {"shape": "point", "center": [1, 1, 2], "flux": 1000.0}


def light_of(name):
    return luminous_at_1_nm(power_at_1_nm(illuminant(name, "test")))


def samples():
    """The 99 measured reflectances of CIE 224:2017, none of them a Munsell chip."""
    import colour
    from colour.quality.cfi2017 import load_TCS_CIE2017

    found = load_TCS_CIE2017(colour.SpectralShape(380, 780, 5))
    return found.wavelengths, np.clip(found.values.T, 0, 0.99)


@pytest.mark.parametrize("name", LAMPS)
def test_paints_that_the_fit_has_not_seen_are_within_one_percent(name):
    light, (nm, curves) = light_of(name), samples()
    bands = nodes_for_lamps([light], [1.0])
    flux = band_flux(illuminant(name, "test"), 1.0, bands, "test")
    assert (flux >= 0).all()
    truth = [light @ (1 / (1 - np.interp(cie_1931()[0], nm, c))) / light.sum() for c in curves]
    got = [flux @ (1 / (1 - np.interp(bands.nodes, nm, c))) for c in curves]
    # The promise of the issue: a 95th percentile below 1 % of E_T/E_D in the deck's room.
    assert np.quantile(np.abs(np.divide(got, truth) - 1), 0.95) < 0.01


def test_searched_nodes_are_better_than_those_the_search_starts_from():
    nm, curves = samples()

    def worst(light, nodes):
        weights = node_weights(light, nodes)
        truth = [light @ (1 / (1 - np.interp(cie_1931()[0], nm, c))) / light.sum() for c in curves]
        got = [weights @ (1 / (1 - np.interp(nodes, nm, c))) for c in curves]
        return np.quantile(np.abs(np.divide(got, truth) - 1), 0.95)

    lights = [light_of(name) for name in LAMPS]
    assert np.mean([worst(x, place_nodes([x], [1.0])) for x in lights]) \
        < 0.8 * np.mean([worst(x, np.array(FIRST_NODES)) for x in lights])


def test_a_laser_on_the_grid_is_one_node():
    line = Spectrum(np.array([449.0, 450.0, 451.0]), np.array([0.0, 1.0, 0.0]))
    light = luminous_at_1_nm(power_at_1_nm(line))
    nodes = place_nodes([light], [1.0])
    weights = node_weights(light, nodes)
    assert 450.0 in nodes
    assert weights[nodes == 450.0] == pytest.approx(1, abs=1e-3)


def test_dark_lamps_and_none_leave_the_nodes_where_they_start():
    np.testing.assert_array_equal(place_nodes([], []), FIRST_NODES)
    np.testing.assert_array_equal(place_nodes([light_of("A")], [0.0]), FIRST_NODES)


def test_a_lamp_counts_by_its_lumens_in_any_division():
    a, b = light_of("FL11"), light_of("HP1")
    np.testing.assert_array_equal(place_nodes([a, b, b], [10.0, 20.0, 30.0]), place_nodes([a, b], [1.0, 5.0]))
    np.testing.assert_array_equal(place_nodes([a, b], [1.0, 1e-9]), place_nodes([a], [1.0]))


def test_twelve_lamps_in_one_room_keep_their_lumens_and_read_like_narrow_bands(room):
    names = (*LAMPS, "FL12", "LED-V1", "LED-RGB1", "E", "FL7", "HP3")
    lamps = [{**POINT, "center": [0.3 + 0.25 * k, 2.0, 2.0], "flux": 100.0 * (k + 1), "spectrum": name}
             for k, name in enumerate(names)]
    scene = room({"munsell": "7.5R 4/12"}, luminaires=lamps)
    bands = scene.band_set("6")
    flux = scene.flux(bands)
    np.testing.assert_allclose(flux.sum(axis=1), 100.0 * np.arange(1, 13), rtol=1e-12)
    assert set(bands.nodes) <= set(GRID)
    # In the deck's room, E_T = Σ flux/(1 − ρ): 1 %, as promised of paints.
    fine = band_set("61")
    total = [float((scene.flux(b) @ (b.luminous / (1 - scene.reflectance(b)[0]))).sum())
             for b in (bands, fine)]
    assert total[0] == pytest.approx(total[1], rel=0.01)


def test_a_lamp_outside_what_is_seen_is_refused_as_in_every_band_set():
    from renderer.errors import InputError

    infrared = Spectrum(np.array([745.0, 750.0, 755.0]), np.array([0.0, 1.0, 0.0]))
    for bands in (band_set("31"), nodes_for_lamps([luminous_at_1_nm(power_at_1_nm(infrared))], [1.0])):
        with pytest.raises(InputError, match="has no light between"):
            band_flux(infrared, 100.0, bands, "scene.toml: luminaires 'lamp'")


@pytest.mark.parametrize(("name", "width"), [("9", 37.5), ("16", 20.0), ("31", 10.0), ("61", 5.0)])
def test_bands_of_one_width_are_centred_from_400_to_700(name, width):
    bands = band_set(name)
    np.testing.assert_allclose(bands.widths, width, rtol=1e-12)
    np.testing.assert_allclose(bands.centres[[0, -1]], [400, 700], rtol=1e-12)
    assert bands.knows_spectrum == (width <= 10)


@pytest.mark.parametrize("bands", ["6", "9"])
def test_values_that_few_bands_cannot_give_are_null_with_the_reason(here, tmp_path, bands):
    said = here("photometer", "grey_room", "--bands", bands, "--accuracy", "5%", "--json", "--quiet",
                cwd=tmp_path)
    reading = json.loads(said.stdout)["readings"][0]
    unknown = ("xy", "cct_K", "duv", "cri_ra", "cri_r9", "tm30_rf", "melanopic_edi_lx", "alpha_opic",
               "spectrum")
    assert all(reading[key] is None and "use --bands 31" in reading["unknown"][key] for key in unknown)
    # The panel's cosine exchange with the floor: 4,000 lm, direct light in closed form is test_photometer's.
    assert reading["illuminance_lx"]["total"] == pytest.approx(144.89, abs=0.1)


def test_a_picture_from_nodes_is_refused_and_a_luminance_map_is_not(here, tmp_path):
    said = here("render", "grey_room", "--bands", "6", cwd=tmp_path)
    assert (said.returncode, said.stdout) == (2, "")
    assert said.stderr.count("\n") == 1
    assert "no colour" in said.stderr
    assert "pseudocolour" in said.stderr
