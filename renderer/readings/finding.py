"""The error of RGB in a room, as a number and as a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import fmean


def rgb_error_percent(rgb: float, spectral: float) -> float | None:
    """100 (RGB ÷ 31 bands − 1) [%] of two illuminances [lx]; None where no light arrives."""
    return 100 * (rgb / spectral - 1) if spectral > 0 else None


@dataclass(frozen=True)
class Comparison:
    """One illuminance in RGB and in 31 bands [lx].

    rgb, spectral : the two; direct : straight from the luminaires, in 31 bands [lx]
    bar : 95 % half-width in 31 bands [lx]
    """

    name: str
    rgb: float
    spectral: float
    direct: float
    bar: float

    @property
    def percent(self) -> float | None:
        """Error of RGB [%]; None where no light arrives."""
        return rgb_error_percent(self.rgb, self.spectral)

    @property
    def bar_percent(self) -> float:
        """Uncertainty of that error [%].

        RGB and 31 bands share mesh, rays and direct light, so their common errors cancel. If the reading's
        whole error is in its indirect light, the relative error of that is bar/indirect, and so is that of
        the difference. It is doubled because RGB and 31 bands weight the surfaces differently.
        """
        indirect = self.spectral - self.direct
        if self.percent is None or not indirect > 0:
            return 0.0
        # The difference between RGB and 31 bands has twice the relative error of a reading
        # (benchmarks/rgb_bars.py).
        return 2.0 * abs(self.percent) * self.bar * (1 / indirect + 1 / self.spectral)

    @property
    def claimed(self) -> bool:
        """Whether the error of RGB is larger than its uncertainty."""
        return self.percent is not None and is_claimed(self.percent, self.bar_percent)


def is_claimed(percent: float, bar: float) -> bool:
    """Whether an error [%] is larger than its bar [%], and than a hundredth of a per cent."""
    return abs(percent) > max(bar, 0.01)


def of_reading(reading) -> list[Comparison]:
    """The comparison for a photometer's reading; [] where it was not read in RGB beside 31 bands."""
    if reading.rgb_lx is None:
        return []
    return [Comparison(reading.name, reading.rgb_lx, reading.total_lx, reading.direct_lx,
                       reading.uncertainty)]


def of_grid(reading) -> list[Comparison]:
    """The comparisons for a grid's mean and for the point where the error of RGB is largest; [] where it was
    not read in RGB."""
    if reading.rgb is None:
        return []
    k, x = reading.worst_point, reading.grid.points[reading.read]
    at = ", ".join(f"{c:.3g}" for c in x[k])
    return [Comparison(reading.grid.name, float(reading.rgb.mean()), reading.mean.value,
                       float(reading.direct.mean()), reading.mean.uncertainty),
            Comparison(f"{reading.grid.name} at ({at}) m", float(reading.rgb[k]), float(reading.total[k]),
                       float(reading.direct[k]), float(reading.uncertainty[k]))]


@dataclass(frozen=True)
class Finding:
    """The error of RGB in one room: on average over its readings, and where it is largest.

    readings : one for each photometer and one for each grid (its mean); extremes : points of grids
    """

    title: str
    readings: Sequence[Comparison]
    extremes: Sequence[Comparison] = ()

    @property
    def lit(self) -> list[Comparison]:
        """The readings at which light arrives."""
        return [one for one in self.readings if one.percent is not None]

    @property
    def percent(self) -> float | None:
        """Mean error of RGB over the readings [%]; None without light."""
        return fmean(one.percent for one in self.lit) if self.lit else None

    @property
    def bar(self) -> float:
        """Mean uncertainty of their errors [%]."""
        return fmean(one.bar_percent for one in self.lit) if self.lit else 0.0

    @property
    def claimed(self) -> bool:
        """Whether the mean error is larger than its bar."""
        return self.percent is not None and is_claimed(self.percent, self.bar)

    @property
    def worst(self) -> Comparison | None:
        """The place where the error of RGB is largest, of those where it is larger than its bar; None if
        nowhere."""
        places = [one for one in (*self.readings, *self.extremes) if one.claimed]
        return max(places, key=lambda one: abs(one.percent), default=None)

    @property
    def amount(self) -> str:
        """The mean error in words: "5.2 % too bright", "right" or "dark"."""
        return "dark" if self.percent is None else in_words(self.percent) if self.claimed else "right"

    @property
    def sentence(self) -> str:
        """The finding for this room in one sentence."""
        room = room_name(self.title)
        if not self.readings:
            return f"No reading compares RGB with 31 bands in {room}."
        if self.percent is None:
            return f"No light arrives at the photometers of {room}: RGB cannot be compared with 31 bands."
        if self.worst is None:
            return self._right(room)
        where = f"{at(self.worst.name)}, where {share(self.worst)} of the light is direct"
        if len(self.lit) == 1 and not self.extremes:
            return f"RGB makes {room} {in_words(self.worst.percent)} {where}."
        mean = f"RGB makes {room} {self.amount} on average" if self.claimed else \
            f"RGB is right in {room} on average"
        over = f" over {len(self.lit)} readings" if len(self.lit) > 1 else ""
        return f"{mean}{over}; it is worst {where}: {in_words(self.worst.percent)} there."

    def _right(self, room: str) -> str:
        bar = max(one.bar_percent for one in self.lit)
        if bar < 0.1:
            return f"RGB is right in {room}."
        return f"RGB is right in {room}, to within the error bar of ± {bar:.2g} %."


def headline(findings: Sequence[Finding]) -> str:
    """One sentence for several rooms, rooms with an error first. For a single room, its own sentence."""
    if len(findings) == 1:
        return findings[0].sentence
    wrong = [f"{room_name(f.title)} {f.amount}" for f in findings if f.claimed]
    mixed = [f"{room_name(f.title)} is right on average, {in_words(f.worst.percent)} at worst"
             for f in findings if not f.claimed and f.worst is not None]
    right = [room_name(f.title) for f in findings if f.percent is not None and not f.claimed and not f.worst]
    dark = [room_name(f.title) for f in findings if f.percent is None]
    parts = ["RGB makes " + ", ".join(wrong)] if wrong else []
    if right and not wrong and not mixed:
        parts.append(f"RGB is right in {in_a_row(right)}")
        right = []
    parts += mixed
    if right:
        parts.append(f"{in_a_row(right)} {'is' if len(right) == 1 else 'are'} right")
    if dark:
        parts.append(f"no light arrives at the photometers of {in_a_row(dark)}")
    text = "; ".join(parts) + "."
    return text if wrong or not mixed else f"In RGB {text}"


def in_words(percent: float) -> str:
    """An error [%] in words: "5.2 % too bright", "0.03 % too dark"."""
    return f"{digits(abs(percent))} % too {'bright' if percent > 0 else 'dark'}"


def signed(percent: float | None) -> str:
    """An error with its sign: "+5.2 %", "−0.03 %", "0 %"; a dash where it is not known."""
    if percent is None:
        return "–"
    if abs(percent) < 0.005:
        return "0 %"
    return f"{'+' if percent > 0 else '−'}{digits(abs(percent))} %"


def digits(value: float) -> str:
    """A positive number with two digits, or in whole units from 10 on."""
    return f"{value:.0f}" if value >= 9.95 else f"{value:.1f}" if value >= 0.995 else f"{value:.2g}"


def share(one: Comparison) -> str:
    """Share of direct light in a reading, in per cent."""
    return f"{100 * min(1.0, one.direct / one.spectral):.0f} %"


def room_name(title: str) -> str:
    """A room within a sentence: "the grey room" for "Grey room"; other titles in quotes."""
    words = title.split()
    # Last words of a title that a sentence may use as a common noun: "the office", not “Office”.
    kinds = ("atrium", "bathroom", "bedroom", "classroom", "corridor", "gallery", "hall", "kitchen",
             "laboratory", "library", "lobby", "museum", "office", "room", "shop", "stage", "studio", "ward",
             "workshop")
    if not words or len(words) > 4 or words[-1].lower() not in kinds:
        return f"“{title}”"
    first = title[0].lower() if title[1:2].islower() else title[0]
    named = words[0].lower() in ("my", "our", "the", "a", "an")
    return f"{'' if named else 'the '}{first}{title[1:]}"


def at(name: str) -> str:
    """A photometer's place in a sentence: "at floor centre", "on the desk", "under the table"."""
    prepositions = ("above", "at", "behind", "below", "beside", "between", "in", "inside", "near", "on",
                    "outside", "over", "under")
    return name if name.split()[:1] and name.split()[0].lower() in prepositions else f"at {name}"


def in_a_row(items: Sequence[str]) -> str:
    """Words in a row: a; a and b; a, b and c."""
    return " and ".join([", ".join(items[:-1]), items[-1]] if len(items) > 1 else items)
