"""Faults of the system: closed streams, full disks, odd names, signals and clusters end with one sentence."""

import os
import resource
import signal
import socket
import subprocess
import sys
import time

import pytest
from untrusted import BASE, CAMERA, refused

from renderer.errors import InputError
from renderer.system import threads
from renderer.system.files import output_folder, whole_file


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "base.toml").write_text(BASE)
    (tmp_path / "room.toml").write_text(BASE + CAMERA)
    return tmp_path


SURROUNDINGS = ("streams closed or full, names that are not UTF-8, wrong RENDERER_CORES, a full disk, files "
                "left by a killed run")
SCHEDULERS = "addresses of no scheduler, and a cluster without workers"
SIGNALS = "SIGTERM and SIGINT at 40 moments of a run each, from its imports to its end"


def shell(folder, line: str, arguments="photometer base.toml --accuracy 20% --quiet", **environment):
    command = f"{sys.executable} -m renderer {arguments} {line}"
    return subprocess.run(["bash", "-c", command], cwd=folder, capture_output=True, text=True, timeout=100,
                          env={**os.environ, **environment})


def test_closed_and_full_streams(folder, held):
    refused(shell(folder, ">&-"), "standard output is closed", code=1)
    done = shell(folder, "2>&-")
    assert done.returncode == 0
    assert "p" in done.stdout
    assert shell(folder, ">&- 2>&- <&-", "keys").returncode == 1
    refused(shell(folder, "> /dev/full", "keys"), "No space left", code=1)
    assert shell(folder, "--bands 32 2> /dev/full").returncode == 2
    held(SURROUNDINGS, 5)


@pytest.mark.parametrize("cores", ["0", "-1", "1.5", "", "9" * 30, "½", "٣"])
def test_a_wrong_number_of_cores_gives_one_sentence(monkeypatch, cores, held):
    monkeypatch.setenv("RENDERER_CORES", cores)
    with pytest.raises(InputError, match=r"RENDERER_CORES is .* 1 to 4096"):
        threads._cores()
    held(SURROUNDINGS)


def test_a_wrong_number_of_cores_ends_a_command_with_one_sentence(folder, held):
    refused(shell(folder, "", RENDERER_CORES="abc"), "RENDERER_CORES", "1 to 4096")
    held(SURROUNDINGS)


def _limited():
    resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, 20_000))


def test_a_full_disk_gives_one_sentence_and_no_partial_file(folder, run, held):
    """A limit on the size of files stands for a full disk: the same calls fail, with EFBIG for ENOSPC."""
    done = run("render", "room.toml", "--accuracy", "20%", "--quiet", "--no-cache", cwd=folder,
               preexec_fn=_limited)
    refused(done, "cannot be written (File too large)", code=1)
    left = {path.name for path in (folder / "outputs").iterdir()}
    assert left <= {"room_31.png", "room_31_luminance.exr", "room_31.vtp"}  # those that fit, whole
    held(SURROUNDINGS)


def test_names_that_are_not_utf_8_work(folder, here, held):
    name = os.fsdecode(b"n\xff.toml")
    (folder / name).write_text(BASE + CAMERA)
    for command in ("report", "compare", "render", "photometer"):
        done = here(command, name, "--accuracy", "20%", "--quiet", cwd=folder)
        assert done.returncode == 0, done.stderr
        assert "\udcff" not in done.stdout + done.stderr
    held(SURROUNDINGS, 4)


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_at_any_moment_is_at_most_one_sentence(folder, how, held):
    """From the first instruction to the last, imports included; 40 moments over a whole run."""
    command = [sys.executable, "-m", "renderer", "photometer", "room.toml", "--accuracy", "20%", "--quiet"]
    started = time.monotonic()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    whole = time.monotonic() - started
    begins = 0.08 * whole  # before that, Python itself starts
    for k in range(40):
        process = subprocess.Popen(command, cwd=folder, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        time.sleep(begins + whole * k / 40)
        process.send_signal(how)
        _, said = process.communicate(timeout=60)
        assert "Traceback" not in said, said
        assert said.count("\n") <= 1, said
        assert process.returncode in (0, 1, 128 + how, -how), said
        held(SIGNALS)


def test_parts_left_by_a_killed_run_are_swept_up(tmp_path, held):
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    left = tmp_path / f".0123abcd.{dead.pid}.part.png"
    mine, other = tmp_path / f".0123abcd.{os.getpid()}.part.png", tmp_path / ".part.of.something"
    for path in (left, mine, other):
        path.touch()
    output_folder(tmp_path)
    assert not left.exists()
    assert mine.exists()
    assert other.exists()
    held(SURROUNDINGS)


def test_a_file_with_a_name_as_long_as_names_may_be_is_written(tmp_path):
    path = tmp_path / ("x" * 251 + ".csv")
    with whole_file(path) as part:
        part.write_text("whole")
    assert path.read_text() == "whole"


def test_silent_and_wrong_schedulers_are_one_sentence(monkeypatch, held):
    pytest.importorskip("distributed", reason="Dask is not installed: pip install '.[cluster]'")
    from renderer.studies import cluster

    monkeypatch.setattr(cluster, "ANSWER_TIMEOUT_S", 0.5)
    with socket.socket() as silent:
        silent.bind(("127.0.0.1", 0))
        silent.listen()
        at = f"tcp://127.0.0.1:{silent.getsockname()[1]}"
        for address in (at, at.replace("tcp", "ws"), "tls://127.0.0.1:9", "ucx://127.0.0.1:9",
                        "http://127.0.0.1:9", "", "tcp://127.0.0.1:abc", "x" * 5000, "\x1b[2J"):
            with pytest.raises(InputError, match="where no scheduler answers") as error:
                cluster.refuse_silence(address)
            assert len(str(error.value)) < 800
            held(SCHEDULERS)


def test_a_cluster_without_workers_is_given_up_in_time(monkeypatch, held):
    distributed = pytest.importorskip("distributed", reason="Dask is not installed: pip install '.[cluster]'")
    from renderer.errors import SolveError
    from renderer.studies import cluster

    assert cluster.SECONDS_WITHOUT_WORKER < 30
    monkeypatch.setattr(cluster, "SECONDS_WITHOUT_WORKER", 1.0)
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as empty, \
            distributed.Client(empty.scheduler_address) as client, \
            pytest.raises(SolveError, match="has had no worker for"):
        list(cluster.as_done([client.submit(abs, -1)], client))
    held(SCHEDULERS)
