"""Share of RGB's errors inside their bars: coarse readings compared with fine ones, in the packaged rooms.

    python benchmarks/rgb_bars.py [room ...]
"""

import sys

import renderer
from renderer.readings.finding import of_reading
from renderer.solving.refine import solve_and_read

REFERENCE = 0.004


def compared(room: str, accuracy: float, seed: int) -> dict:
    """RGB beside 31 bands at each photometer of a room."""
    _, readings = solve_and_read(renderer.load(room), "31", accuracy, seed)
    return {reading.name: of_reading(reading)[0] for reading in readings}


def main(rooms: list[str]) -> None:
    print("room, accuracy, photometer: error of RGB [%] +- bar; at 0.4 %; distance over both bars")
    inside = total = 0
    for room in rooms:
        fine = compared(room, REFERENCE, 0)
        for accuracy in (0.1, 0.03, 0.01):
            for name, one in compared(room, accuracy, 1).items():
                other = fine[name]
                bar = one.bar_percent + other.bar_percent + 0.01
                apart = abs(one.percent - other.percent) / bar
                inside, total = inside + (apart <= 1), total + 1
                print(f"{room}, {accuracy:.0%}, {name}: {one.percent:.3f} +- {one.bar_percent:.3f}; "
                      f"{other.percent:.3f}; {apart:.2f}")
    print(f"{inside} of {total} inside")


if __name__ == "__main__":
    main(sys.argv[1:] or ["red_room", "furnished_room", "classroom"])
