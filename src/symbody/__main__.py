"""``python -m symbody`` is the command line."""

from symbody.cli import main

if __name__ == "__main__":
    main()
