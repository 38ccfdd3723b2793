"""A scene to damage, and the check of a refusal."""

from conftest import POINT_LIT, scene_text

BASE = scene_text(POINT_LIT)
CAMERA = "[camera]\nposition = [2, 0.1, 1.5]\nlook_at = [2, 4, 1.4]\nresolution = [64, 48]\n"


def refused(done, *words, code=2):
    """One sentence on stderr, no result, that exit code."""
    assert done.returncode == code, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    assert "Traceback" not in done.stderr
    for word in words:
        assert word in done.stderr
