"""Printable: any text on one line."""


def printable(text: str) -> str:
    """A text on one line, whatever a file or its name has put into it."""
    return "".join(character if character.isprintable() else repr(character)[1:-1] for character in text)
