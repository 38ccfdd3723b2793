"""Validation as users run it: every case passes, a wrong one fails, and what is written is whole."""

import json

import pytest

from renderer.studies.validation import run
from renderer.studies.validation.cases import Case

SLOW = {"meshes_and_spectra", "sizes", "sphere"}
STUDIES = [pytest.param(study, marks=[pytest.mark.slow] if study.__name__ in SLOW else [], id=study.__name__)
           for study in (*run.ORACLES, *run.EXTREMES)]


@pytest.mark.parametrize("study", STUDIES)
def test_every_case_passes(study):
    cases = run.cases_of([study])
    assert cases
    assert [case.cells() for case in cases if not case.passes] == []


@pytest.mark.parametrize(("case", "passes"), [
    (Case("g", "c", "q", 1.0, 1.1, 0.09), False),
    (Case("g", "c", "q", 1.0, 1.1, 0.11), True),
    (Case("g", "c", "q", 1.0, float("nan"), 1.0), False),
    (Case("g", "c", "refused", "too thin", "it is too thin."), True),
    (Case("g", "c", "refused", "too thin", "not refused"), False),
    (Case("g", "c", "refused", "too thin", 3.0), False),
])
def test_a_verdict_can_be_either(case, passes):
    assert case.passes == passes


def test_the_command_writes_its_tables_and_fails_where_a_case_fails(here, monkeypatch, tmp_path):
    good, bad = Case("Good", "a", "E", 1.0, 1.0, 0.1, "lx"), Case("Bad", "b|c", "E", 1.0, 2.0, 0.1, "lx")
    for cases, code in (([good], 0), ([good, bad], 1)):
        monkeypatch.setattr(run, "ORACLES", [lambda folder, cases=cases: cases])
        for study in run.ORACLES:
            study.__name__ = "study"
        done = here("validate", "--out", tmp_path, "--quiet", cwd=tmp_path)
        assert done.returncode == code
        record = json.loads((tmp_path / "validation.json").read_text())
        assert (record["passed"], record["failed"]) == (1, len(cases) - 1)
        assert "pass" in done.stdout
    assert "1 of 2 cases fail, the first: b|c, E." in done.stderr
    assert "FAIL" in (tmp_path / "validation.md").read_text()
