"""The command for one photometric file: luminaire."""

import json
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from renderer.cli.options import Output
from renderer.cli.terminal import list_files, show, tell


def luminaire(file: str, *, json_: Annotated[bool, Parameter(name="--json", negative="")] = False,
              output: Output | None = None) -> None:
    """A photometric file: flux, beam and field angles, spacing, faults, and a polar diagram.

    Parameters
    ----------
    file
        An IES LM-63 (.ies) or EULUMDAT (.ldt) file.
    json_
        Print one JSON object instead of a table.
    """
    from renderer.scene.photometric.files import read_photometry
    from renderer.studies.luminaire import photometry_record, photometry_rows, save_diagram
    from renderer.system.files import output_folder

    output = output or Output()
    path = Path(file)
    photometry = read_photometry(path, "FILE")
    record = photometry_record(photometry, path)
    out = output_folder(output.out)
    diagram = save_diagram(photometry, record, out / f"{path.stem}_polar.png")
    if json_:
        tell(json.dumps(record, indent=1, allow_nan=False))
        return
    show(path.name, ["quantity", "value"], photometry_rows(record))
    for fault in record["faults"]:
        tell(f"Fault: {fault}")
    if not record["faults"]:
        tell("No fault found.")
    list_files([diagram], out)
