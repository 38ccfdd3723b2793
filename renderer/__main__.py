"""`python -m renderer` is the command `renderer`."""

from renderer.cli import main

main()
