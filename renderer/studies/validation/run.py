"""The run of all cases of validation, and their files."""

import json
import tempfile
from pathlib import Path

from renderer.solving.transport_store import Progress
from renderer.studies.validation import colours, extremes, lines, photometry
from renderer.studies.validation.cases import Case, cases_markdown
from renderer.studies.validation.exact.cases import below_an_uplight, exact_rooms
from renderer.system.files import whole_file

ORACLES = (photometry.form_factors, photometry.cie_171, photometry.closed_rooms, photometry.sphere,
           photometry.planes, photometry.furnace, below_an_uplight, exact_rooms, colours.planck,
           colours.daylight, colours.colorimetry, colours.alpha_opic_efficacies, lines.lines_of_light,
           lines.published_colours)

EXTREMES = (extremes.reflectances, extremes.sizes, extremes.lamps_and_meters, extremes.objects,
            extremes.meshes_and_spectra, extremes.single_precision)


def cases_of(studies, progress: Progress = lambda step: None) -> list[Case]:
    """The cases of some studies, each with an empty folder for its scene files."""
    found = []
    for study in studies:
        progress(f"validation: {study.__name__.replace('_', ' ')}")
        with tempfile.TemporaryDirectory() as folder:
            found += study(Path(folder))
    return found


def save_cases(cases: list[Case], out: Path, stem: str) -> list[Path]:
    """Write `stem`.json, and `stem`.md with the tables of docs/verification.md."""
    files = [out / f"{stem}.json", out / f"{stem}.md"]
    passed = sum(case.passes for case in cases)
    record = {"cases": [case.record() for case in cases], "passed": passed, "failed": len(cases) - passed}
    with whole_file(files[0]) as part:
        part.write_text(json.dumps(record, indent=1, allow_nan=False))
    with whole_file(files[1]) as part:
        part.write_text(f"{passed} of {len(cases)} cases pass.\n\n{cases_markdown(cases)}")
    return files
