"""Photometric files written for tests, and what they mean."""

import numpy as np

GAMMA = np.arange(0, 180.1, 5.0)


def ies(
    candela,
    vertical=GAMMA,
    horizontal=(0.0,),
    kind=1,
    size=(0, 0, 0),
    lumens=-1,
    factors=(1, 1, 10),
    multiplier=1,
    edition="IESNA:LM-63-2002",
    tilt="TILT=NONE",
    units=2,
    end="\r\n",
    keywords=("[TEST] x", "[LUMINAIRE] lamp"),
):
    """An LM-63 file of intensities (planes, angles); size is width, length, height."""
    rows = [
        *([edition] if edition else []),
        *keywords,
        tilt,
        f"1 {lumens} {multiplier} {len(vertical)} {len(horizontal)} {kind} {units} "
        + " ".join(map(str, size)),
        "{} {} {}".format(*factors),
    ]
    rows += [" ".join(f"{x:.10g}" for x in row) for row in (vertical, horizontal, *np.atleast_2d(candela))]
    return end.join(rows) + end


def ldt(
    candela,
    planes,
    symmetry,
    gamma=GAMMA,
    size=(0, 0),
    lumens=1000,
    output=100.0,
    downward=50,
    end="\r\n",
    conversion=1,
    name="lamp",
):
    """A EULUMDAT file of intensities (stored planes, angles) in cd/klm; planes lists them all."""
    step = planes[1] - planes[0] if len(planes) > 1 else 0
    rows = [
        "maker",
        1,
        symmetry,
        len(planes),
        step,
        len(gamma),
        gamma[1] - gamma[0],
        "",
        name,
        "",
        "",
        "",
        0,
        0,
        0,
        1000 * size[0],
        1000 * size[1],
        0,
        0,
        0,
        0,
        downward,
        output,
        conversion,
        0,
        1,
        1,
        "LED",
        lumens,
        "",
        "",
        10,
    ]
    rows += [0] * 10 + [f"{x:.10g}" for x in (*planes, *gamma, *np.ravel(candela))]
    return end.join(map(str, rows)) + end


def directions(n=400, seed=0):
    """Unit vectors (n, 3) all round, by C0, C90 and nadir; and their C and γ (n,) [rad]."""
    d = np.random.default_rng(seed).normal(size=(n, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    return d, np.arctan2(d[:, 1], d[:, 0]), np.arccos(d[:, 2])


def smooth(c, gamma):
    """Intensity [cd] that is the same on both sides of C0–C180 and of C90–C270; angles (…) [rad]."""
    return 100 * (1.2 + np.cos(gamma) + 0.3 * np.sin(gamma) ** 2 * np.cos(2 * c))


SMOOTH_FLUX = 4 * np.pi * 120
"""Of `smooth` [lm]: the cosines integrate to nothing."""


def sampled(planes, gamma=GAMMA, law=smooth):
    """A law's values (planes, angles)."""
    return law(np.radians(np.asarray(planes, dtype=float))[:, None], np.radians(gamma)[None])
