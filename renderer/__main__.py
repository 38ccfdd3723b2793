"""`python -m renderer` is the command `renderer`."""

import sys


def main() -> None:
    """Run the command line. Ctrl-C ends it with a sentence even while its modules are imported."""
    try:
        from renderer.cli import main as command
    except KeyboardInterrupt:
        print("renderer: interrupted; nothing has been done.", file=sys.stderr)  # noqa: T201
        sys.exit(1)
    command()


if __name__ == "__main__":
    main()
