"""IFC files, the building models of architects: spaces, furniture and light fixtures, by ifcopenshell (LGPL).

ifcopenshell reads in a process of its own, so that a faulty file can end only that process.
"""

import pickle
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from renderer.scene.imports.record import Imported, NotImported


def read_ifc(path: Path, _data: bytes) -> Imported:
    """Read an IFC file. Raises NotImported."""
    if find_spec("ifcopenshell") is None:
        raise NotImported('is IFC, which the package ifcopenshell reads; install it with '
                          'pip install "spectral-radiosity[import]"')
    minutes = 30  # time limit
    with tempfile.TemporaryDirectory() as folder:
        result = Path(folder) / "read.pickle"
        command = [sys.executable, "-m", "renderer.scene.imports.ifc", str(path.resolve()), str(result)]
        try:
            done = subprocess.run(command, capture_output=True, timeout=60 * minutes, check=False)
        except subprocess.TimeoutExpired:
            raise NotImported(f"took more than {minutes} minutes to read; export one storey of it") from None
        if done.returncode != 0 or not result.exists():
            said = (done.stderr.decode(errors="replace").strip().splitlines() or ["it stopped"])[-1]
            raise NotImported(f"cannot be read by ifcopenshell ({' '.join(said.split())[:120]}); export it "
                              "again, as IFC4 or IFC2x3")
        found = pickle.loads(result.read_bytes())
    if isinstance(found, str):
        raise NotImported(found)
    return found


def _main() -> None:
    from renderer.scene.imports.ifc_model import read_ifc_model

    source, target = map(Path, sys.argv[1:3])
    try:
        found = read_ifc_model(source)
    except NotImported as fault:
        found = str(fault)
    target.write_bytes(pickle.dumps(found))


if __name__ == "__main__":
    _main()
