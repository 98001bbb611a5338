"""Near matches for a misspelt name."""

from __future__ import annotations

from collections.abc import Iterable

_LONGEST = 60  # comparing is quadratic in the lengths; no name of ours is longer
_FARTHEST = 5
_MOST = 200


def near_hint(name: str, known: Iterable[str]) -> str:
    """``did you mean 'theta'?``, or nothing where no known name is near."""
    match = near_match(name, known)
    return f"did you mean '{match}'?" if match else ""


def near_match(name: str, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The known name that is nearest to ``name``, or nothing where none is near.

    ``cutoff`` is the part of the letters of both that must agree.
    """
    import difflib

    if len(name) > _LONGEST:
        return ""
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
    return " ".join(hint for hint in (near_hint(name, known), known_hint(known)) if hint)
