"""Near matches for a misspelt name."""

from __future__ import annotations

from collections.abc import Iterable

_FOREIGN = "авемтԁցһіјкӏорԛгѕсυѵԝхуАВЕНІЈКМОРԚЅСТԜХУαγινορκχΑΒΕΖΗΙΚΜΝΟΡΤΥΧɑɡıⅰ"
_LATIN = "abemtdghijklopqrscuvwxyABEHIJKMOPQSCTWXYayivopkxABEZHIKMNOPTYXagii"
"""Letters of other alphabets that look like Latin ones, and these."""
_LONGEST = 60  # comparing is quadratic in the lengths; no name of ours is longer
_FARTHEST = 5
_MOST = 200


def look_alike(name: str, known: Iterable[str]) -> str:
    """The known name that looks like ``name``, with letters of another alphabet; or nothing."""
    table = str.maketrans(_FOREIGN, _LATIN)
    seen = name.translate(table)
    words = (word for word in known if not (name.isascii() and word.isascii()) and word != name)
    return next((word for word in words if word.translate(table) == seen), "")


def look_alike_hint(name: str, known: Iterable[str]) -> str:
    """The same as a hint, which says which letter differs."""
    import unicodedata

    match = look_alike(name, known)
    if not match:
        return ""
    here, there = next((one, other) for one, other in zip(name, match) if one != other)
    whose, letter = ("Its", there) if here.isascii() else ("This", here)
    called = unicodedata.name(letter).capitalize()
    return f"did you mean '{match}'? {whose} '{letter}' is another letter that looks the same: {called}"


def near_hint(name: str, known: Iterable[str]) -> str:
    """``did you mean 'theta'?``, or nothing where no known name is near."""
    known = tuple(known)
    if alike := look_alike_hint(name, known):
        return alike
    match = near_match(name, known)
    return f"did you mean '{match}'?" if match else ""


def near_match(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The known name that is nearest to ``name``, or nothing where none is near.

    ``cutoff`` is the part of the letters of both that must agree.
    """
    import difflib

    if len(name) > _LONGEST:
        return ""
    known = tuple(known)
    if alike := look_alike(name, known):
        return alike
    candidates = [word for word in known if abs(len(word) - len(name)) <= _FARTHEST][:_MOST]
    by_lower_case = {word.lower(): word for word in reversed(candidates)}
    if name.lower() in by_lower_case:
        return by_lower_case[name.lower()]
    return next(iter(difflib.get_close_matches(name, candidates, n=1, cutoff=cutoff)), "")


def known_hint(known: Iterable[str], limit: int = 16) -> str:
    """``known: a, b, c``: what could have been written, cut off when there is too much of it."""
    words = list(known)
    shown = ", ".join(words[:limit])
    return f"known: {shown}{', ...' if len(words) > limit else ''}" if words else ""


def shown(name: str) -> str:
    """The name in quotes, shortened if it is very long."""
    return f"'{name if len(name) <= _LONGEST else name[:_LONGEST] + '...'}'"


def suggest(name: str, known: Iterable[str]) -> str:
    """The words that were perhaps meant, and all known words."""
    known = tuple(known)
    hints = [hint for hint in (near_hint(name, known), known_hint(known)) if hint]
    return (" " if hints[0].endswith("?") else "; ").join(hints) if hints else ""
