"""Studies of many rooms: every combination once, also when workers die."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from multiprocessing import active_children

import pytest
from conftest import run_here
from study_files import PAINTS, VALUES, rows, settings, study

import renderer
from renderer.errors import InputError
from renderer.studies import sweep as studies
from renderer.studies import sweep_runs
from renderer.studies.sweep import identity, read_study
from renderer.studies.sweep_runs import READING_COLUMNS, Journal, run_sweep

EVERY = [(rho, flux) for rho in VALUES for flux in (1000.0, 2000.0)]


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """A folder with a sweep done, and what it returned."""
    folder = tmp_path_factory.mktemp("swept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sweep_runs, "on_cores", run_here)
        return folder, run_sweep(study(folder), folder, False, None, lambda step: None)


@pytest.fixture
def finished(swept, tmp_path):
    """A copy of that folder."""
    return shutil.copytree(swept[0], tmp_path / "copy")


def test_every_room_appears_once_in_order_and_reads_as_alone(swept):
    files, now, total = swept[1]
    table = rows(files)
    assert (now, total) == (16, 16)
    assert settings(table) == EVERY
    alone = renderer.solve(renderer.load("grey_room"), "rgb", 0.2).photometer([2.7, 2.7, 0], [0, 0, 1])
    # grey_room itself is 0.2 and 4,000 lm; light is in proportion to the lumens.
    of_two = float(table[7]["total_lx"])
    assert settings(table)[7] == (0.2, 2000.0)
    assert of_two == pytest.approx(alone.total_lx / 2, rel=1e-6)
    lux = [float(r["total_lx"]) for r in table[::2]]
    assert lux == sorted(lux)


def test_a_killed_worker_loses_nothing_and_nothing_is_done_twice(tmp_path):
    killed, steps = [], []

    def kill_one(step):
        steps.append(step)
        if len(steps) == 2 and not killed:  # one batch is done; all workers are at work
            killed.append(active_children()[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    files, now, _ = run_sweep(study(tmp_path), tmp_path, False, None, kill_one)
    assert killed
    assert now == 16
    assert settings(rows(files)) == EVERY
    lines = (tmp_path / ".paints.journal").read_text().splitlines()
    assert len(lines) == len(set(lines)) == 1 + 16  # whose it is, and the rooms


def test_an_interrupted_sweep_goes_on_where_it_was(finished, one_process):
    table = finished / "paints.csv"
    first = table.read_bytes()
    journal = finished / ".paints.journal"
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:12]) + lines[12][:40])  # died in the middle of a line
    table.unlink()
    files, now, total = run_sweep(study(finished), finished, False, None, lambda step: None)
    assert (now, total) == (5, 16)
    assert files[0].read_bytes() == first
    assert len(Journal(journal).done) == 16


def test_a_changed_room_is_done_again_and_the_others_are_not(finished, one_process):
    more = study(finished, [*VALUES, 0.6])
    assert run_sweep(more, finished, False, None, lambda step: None)[1:] == (2, 18)
    other = study(finished, [0.1], accuracy=0.3)
    assert len(Journal(finished / ".paints.journal").done) == 18
    assert run_sweep(other, finished, False, None, lambda step: None)[1:] == (2, 2)


def test_a_room_that_cannot_be_solved_is_a_row_that_says_so(tmp_path, one_process):
    text = 'scenes = ["grey_room"]\n[vary]\n"luminaires.0.normal" = [[0, 0, -1], [0, 0, 1]]'
    files, *_ = run_sweep(study(tmp_path, text=text), tmp_path, False, None, lambda step: None)
    good, bad = rows(files)
    assert not good["fault"]
    assert float(good["total_lx"]) > 0
    assert "none of its light enters the room" in bad["fault"]
    assert bad["total_lx"] == ""


def names(read):
    return [identity(read.bases[case.base], case) for case in read.cases()]


@pytest.mark.parametrize("scene", ["a.toml", "sub/a.toml"])
def test_a_changed_file_that_only_a_value_names_is_read_again(painted, one_process, scene):
    text = PAINTS.format(scenes=f'["{scene}"]')
    (painted / "sub" / "p2.csv").unlink()  # so that it lies beside the study, and not beside the second scene

    def swept():
        files, now, _ = run_sweep(study(painted, text=text), painted, False, None, lambda step: None)
        return now, [float(row["total_lx"]) for row in rows(files)]

    (now, before), (again, same) = swept(), swept()
    assert (now, again) == (2, 0)
    assert same == before
    (painted / "p2.csv").write_text("wavelength_nm,reflectance\n400,0.9\n700,0.9\n")
    now, after = swept()
    assert now == 1
    assert after[0] == before[0]
    assert after[1] > 1.5 * before[1]


def test_a_room_is_the_same_wherever_it_is_called_from_and_not_with_another_program(painted, monkeypatch):
    text = PAINTS.format(scenes='["a.toml"]')
    first = names(study(painted, text=text))
    monkeypatch.chdir(painted / "sub")
    assert names(read_study(painted / "sub" / ".." / "paints.toml", 0.2, "rgb", None)) == first
    monkeypatch.chdir(painted)
    assert names(read_study(studies.Path("paints.toml"), 0.2, "rgb", None)) == first
    monkeypatch.setattr(studies, "program", lambda: "another version")
    assert not set(names(study(painted, text=text))) & set(first)


def test_a_file_changed_under_way_stops_the_sweep(painted, one_process):
    read = study(painted, text=PAINTS.format(scenes='["a.toml"]'))
    (painted / "p2.csv").write_text("wavelength_nm,reflectance\n400,0.9\n700,0.9\n")
    with pytest.raises(InputError, match="has changed since the study was read"):
        run_sweep(read, painted, False, None, lambda step: None)


def test_rooms_of_equal_names_are_distinguished_and_others_keep_theirs(painted, one_process):
    shutil.copy(painted / "a.toml", painted / "sub" / "b.toml")
    text = PAINTS.format(scenes='["a.toml", "sub/a.toml", "sub/b.toml"]')
    files, *_ = run_sweep(study(painted, text=text), painted, False, None, lambda step: None)
    assert [row["scene"] for row in rows(files)[::2]] == ["a.toml", "sub/a.toml", "b"]


@pytest.mark.parametrize("damage", [b"5", b"null", b"[[],[]]", b'["x", [{}]]', b'["x", []]', b"\xff\xfe",
                                    b"{}", b"[" * 100_000])
def test_a_damaged_line_of_the_journal_is_not_done(tmp_path, damage):
    good = ["id", [dict.fromkeys(READING_COLUMNS)]]
    (tmp_path / ".j").write_bytes(damage + b"\n" + json.dumps(good).encode() + b"\n" + damage)
    assert Journal(tmp_path / ".j").done == {"id": good[1]}


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGKILL])
def test_a_killed_sweep_leaves_no_worker_and_loses_no_room(tmp_path, how):
    many = [round(0.001 * k, 3) for k in range(1, 400)]
    study(tmp_path, many)
    process = subprocess.Popen([sys.executable, "-m", "renderer", "sweep", "paints.toml", "--accuracy", "20%",
                                "--bands", "rgb", "--quiet", "--out", "."], cwd=tmp_path, text=True,
                               stderr=subprocess.PIPE)
    journal = tmp_path / ".paints.journal"
    while not (journal.is_file() and len(Journal(journal).done) > 0):
        time.sleep(0.05)
        assert process.poll() is None
    before = Journal(journal).done
    process.send_signal(how)
    try:
        _, said = process.communicate(timeout=20)  # to the end of what the workers, too, may write to
    except subprocess.TimeoutExpired:
        pytest.fail("workers are left")
    assert Journal(journal).done.keys() >= before.keys()
    assert not (tmp_path / "paints.csv").exists()
    if how == signal.SIGTERM:
        assert process.returncode == 143
        assert said.count("\n") == 1
        assert "the same command continues" in said


def test_every_measured_chip_is_a_star(tmp_path):
    text = 'scenes = ["grey_room"]\n[vary]\n"materials.grey.munsell" = "*"\n"luminaires.0.cct" = [3000, 6500]'
    assert len(study(tmp_path, text=text)) == 2 * 1269


def test_a_scheduler_without_dask_or_without_an_answer_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"spectral-radiosity\[cluster\]|no scheduler answers"):
        run_sweep(study(tmp_path), tmp_path, False, "tcp://127.0.0.1:9", lambda step: None)


def test_a_dask_cluster_gives_the_same_table_though_a_worker_dies(tmp_path, swept, cluster):
    killed = []

    def kill_one(step):
        if " 1 of" in step or " 2 of" in step:
            pids = [worker.pid for worker in cluster.workers.values()]
            os.kill(killed.append(pids[0]) or pids[0], signal.SIGKILL)

    files, now, _ = run_sweep(study(tmp_path), tmp_path, False, cluster.scheduler_address, kill_one)
    assert now == 16
    assert killed
    assert files[0].read_bytes() == swept[1][0][0].read_bytes()
