"""Printing of a page to PDF by an installed browser."""

import shutil
import subprocess
import tempfile
from pathlib import Path


def print_pdf(page: Path) -> Path | None:
    """Print an HTML file to a .pdf beside it; None where no browser is installed or the print fails."""
    browsers = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome", "msedge")
    browser = next((found for name in browsers if (found := shutil.which(name))), None)
    if browser is None:
        return None
    pdf = page.with_suffix(".pdf").resolve()
    with tempfile.TemporaryDirectory() as profile:
        command = [browser, "--headless", "--disable-gpu", "--no-sandbox", "--no-pdf-header-footer",
                   f"--user-data-dir={profile}", f"--print-to-pdf={pdf}", page.resolve().as_uri()]
        try:
            subprocess.run(command, check=True, capture_output=True, timeout=120)
        except (subprocess.CalledProcessError, subprocess.TimeoutExpired):
            return None
    return pdf if pdf.is_file() else None
