"""`python -m gaitflow.cli`, as job scripts call it."""

from gaitflow.cli.main import main

if __name__ == "__main__":
    main()
