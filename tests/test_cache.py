"""The cache of form factors: whole files, safe to read, with unchanged numbers."""

import json
import os
import warnings
from io import BytesIO
from multiprocessing import get_context

import numpy as np
import pytest

from renderer.errors import CacheWarning
from renderer.solving.plan import make_plan
from renderer.solving.solution import solve
from renderer.solving.transport_store import TransportStore
from renderer.system import cache
from renderer.system.cache import Cache
from renderer.transport import transport
from renderer.transport.factors import method

CRATE = {"shape": "box", "name": "crate", "position": [0.5, 0.5, 0.0], "size": [1.0, 1.0, 1.0]}
METER = {"name": "floor", "position": [2.5, 2.0, 0.0]}


def never():
    raise AssertionError("the arrays are computed again although they are kept")


def made(value: float = 1.0):
    return {"a": np.full(1000, value), "b": np.arange(3)}


def test_cached_arrays_are_unchanged(tmp_path):
    kept = Cache(tmp_path)
    kept.arrays("one", made)
    again = kept.arrays("one", never)
    np.testing.assert_array_equal(again["a"], made()["a"])
    np.testing.assert_array_equal(again["b"], made()["b"])
    assert kept.arrays("two", lambda: made(2.0))["a"][0] == 2.0


@pytest.mark.parametrize("damage", ["cut", "flip", "empty", "text", "no arrays", "nothing", "one array"])
def test_a_damaged_file_is_computed_again_with_a_warning(tmp_path, damage):
    kept = Cache(tmp_path)
    kept.arrays("one", made)
    (path,) = tmp_path.glob("*.kept")
    held = bytearray(path.read_bytes())
    if damage == "flip":
        held[len(held) // 2] ^= 1
    one = BytesIO()
    np.save(one, np.zeros(3))
    checked = {name: cache._digest(data) + data for name, data in
               {"no arrays": b"not arrays", "nothing": b"", "one array": one.getvalue()}.items()}
    path.write_bytes({"cut": held[:-7], "flip": held, "empty": b"", "text": b"not arrays", **checked}[damage])
    with pytest.warns(CacheWarning, match="damaged"):
        assert kept.arrays("one", lambda: made(3.0))["a"][0] == 3.0
    assert kept.arrays("one", never)["a"][0] == 3.0


def test_the_file_not_used_for_longest_goes_first(tmp_path, monkeypatch):
    kept = Cache(tmp_path)
    for name in "abc":
        kept.arrays(name, made)
    files, size = kept.size
    assert files == 3
    for age, path in enumerate(sorted(tmp_path.glob("*.kept"))):
        os.utime(path, (1e9 - age, 1e9 - age))  # c was used last, by the names' own order of age
    oldest = min(tmp_path.glob("*.kept"), key=lambda path: path.stat().st_mtime)
    monkeypatch.setattr(cache, "MAX_CACHE_BYTES", size)
    kept.arrays("d", made)
    assert not oldest.exists()
    assert len(list(tmp_path.glob("*.kept"))) == 3


def test_a_folder_of_that_name_is_left_alone(tmp_path):
    kept = Cache(tmp_path)
    kept.arrays("one", made)
    (tmp_path / "something.kept").mkdir()
    assert kept.size[0] == 1
    kept.clear()
    assert [path.name for path in tmp_path.iterdir()] == ["something.kept"]


def test_large_arrays_are_not_cached(tmp_path, monkeypatch):
    monkeypatch.setattr(cache, "MAX_CACHE_BYTES", 200)  # and half of that for one result
    Cache(tmp_path).arrays("one", made)
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_to_is_a_warning(tmp_path):
    (tmp_path / "file").touch()
    with pytest.warns(CacheWarning, match="cannot be written"):
        assert Cache(tmp_path / "file" / "below").arrays("one", made)["b"][2] == 2


def _write(folder, value):
    for k in range(50):
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = Cache(folder).arrays(f"key {k % 5}", lambda: made(7.0))
        assert (found["a"] == 7.0).all()


def test_concurrent_processes_keep_files_whole(tmp_path):
    context = get_context("spawn")
    workers = [context.Process(target=_write, args=(tmp_path, k)) for k in range(2)]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    assert [worker.exitcode for worker in workers] == [0, 0]
    assert len(list(tmp_path.iterdir())) == 5  # and no part left


@pytest.mark.parametrize("objects", [(), (CRATE,)])
def test_a_kept_room_gives_the_same_numbers_and_casts_no_ray(room, tmp_path, monkeypatch, objects):
    first = solve(
        room(objects=objects, photometers=[METER]), accuracy=0.05, store=TransportStore(Cache(tmp_path))
    )
    read = first.photometers()[0]
    for module, work in ((transport, "cast"), (method, "count"), (method, "contour_exchange"),
                         (transport, "direct_on_patches"), (transport, "look_round")):
        monkeypatch.setattr(module, work, lambda *args: never())
    # Another material, lamp power and meter: the geometry is the same.
    solve(room(rho=0.8, objects=objects), accuracy=0.05, store=TransportStore(Cache(tmp_path)))
    again = solve(
        room(objects=objects, photometers=[METER]), accuracy=0.05, store=TransportStore(Cache(tmp_path))
    )
    np.testing.assert_array_equal(again.radiosity, first.radiosity)
    same = again.photometers()[0]
    assert (same.total_lx, same.uncertainty) == (read.total_lx, read.uncertainty)


def test_another_geometry_setting_or_program_has_its_own_file(room, tmp_path, monkeypatch):
    kept = Cache(tmp_path / "kept")

    def files(**changed):
        scene = room(objects=[{**CRATE, **changed.get("crate", {})}])
        plan = make_plan(scene, changed.get("accuracy", 0.05), None)
        TransportStore(kept).transport(scene, plan, changed.get("seed", 0))
        return len(list(kept.folder.iterdir()))

    counts = [files(), files(), files(crate={"rotation": 10.0}), files(accuracy=0.03), files(seed=1)]
    monkeypatch.setattr(cache, "code", lambda: "another version")
    counts.append(files())
    assert counts == [3, 3, 6, 9, 12, 15]


def test_the_commands_list_and_clear_the_cache(here, room_file, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "kept"))
    scene = room_file(objects=[CRATE], photometers=[METER]).path
    ask = ("photometer", scene, "--accuracy", "5%", "--json", "--quiet")
    first, again, without = (json.loads(here(*ask, *more, cwd=tmp_path).stdout)
                             for more in ((), (), ("--no-cache",)))
    assert first["readings"] == again["readings"] == without["readings"]
    assert again["rays"] < first["rays"] == without["rays"]
    said = here("cache", "info", cwd=tmp_path).stdout
    assert "3 files" in said  # of the one mesh on which the paths end
    for path in (tmp_path / "kept" / "renderer").glob("*.kept"):  # not every one is read again
        path.write_bytes(b"damaged")
    damaged = here(*ask, cwd=tmp_path)
    assert damaged.returncode == 0
    assert "is damaged" in damaged.stderr
    assert json.loads(damaged.stdout)["readings"] == first["readings"]
    assert "3 files" in here("cache", "clear", cwd=tmp_path).stdout
    assert "0 files" in here("cache", "info", cwd=tmp_path).stdout
