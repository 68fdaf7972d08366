"""`python -m labrig`: the command line, where `labrig` is not on the path."""

from labrig.cli import main

if __name__ == "__main__":
    main()
