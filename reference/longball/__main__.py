"""``python -m longball`` is the command line."""

from longball.cli import main

main()
