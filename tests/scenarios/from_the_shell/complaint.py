"""What `calot` says of a bad call."""

from scenarios.cli import main


def complaint(capfd, *words):
    """Return the only line that is written when `calot` refuses these words."""
    assert main(words) == 2
    out, err = capfd.readouterr()
    assert out == ""
    lines = err.splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("calot: ")
    return lines[0]
