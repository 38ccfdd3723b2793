"""What is kept between runs: renderer cache info, renderer cache clear."""

from cyclopts import App

from renderer.cli.options import Output

app = App(name="cache", help="Form factors kept between runs: what there is, and how to be rid of it.",
          help_format="plaintext")


@app.command
def info(*, output: Output | None = None) -> None:
    """Where form factors are kept, how many files there are, and how large they may become."""
    from renderer.cache import LIMIT, user_cache

    kept = user_cache()
    files, size = kept.size
    print(f"{kept.folder}: {files} files, {size / 1e6:.1f} MB; past {LIMIT / 1e6:.0f} MB the file not used "
          "for longest is removed.")


@app.command
def clear(*, output: Output | None = None) -> None:
    """Remove all of them."""
    from renderer.cache import user_cache

    kept = user_cache()
    files, size = kept.size
    kept.clear()
    print(f"{kept.folder}: {files} files of {size / 1e6:.1f} MB removed.")
