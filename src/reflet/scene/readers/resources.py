"""Finding the files that a scene file refers to, however their names were written."""

import os
import re
import unicodedata
from pathlib import Path
from urllib.parse import unquote

from reflet.errors import RefletError

_ROOT = re.compile(r"[A-Za-z]:[\\/]*|[\\/]+")


def find_resource(folder: Path, name: str, *, is_uri: bool = False) -> Path:
    """The file that a scene file in ``folder`` calls ``name``, as a browser or a Windows user would find it.

    ``is_uri`` names are URIs: a query and a fragment are cut off and escapes such as %20 undone before the name is
    tried as it stands. Other names are tried as they stand first. Backslashes part folders; upper and lower case, the
    Unicode form and the encoding of letters (UTF-8 or Latin-1) do not count where no file matches exactly. file: URIs
    and absolute paths, which mostly are another machine's, are looked for in ``folder`` by as much of their end as
    matches, and at last in its folder ``textures``.

    Raises RefletError, in one sentence, where nothing is found, where several files are meant equally well, and for
    names on the network, which are never followed.
    """
    shown = _shown(name)
    is_file_uri = name.strip().lower().startswith("file:")
    if "://" in name and not is_file_uri:
        raise RefletError(f"{shown} is on the network; download it into {folder} and refer to it there.")
    spellings = _spellings(name, is_uri or is_file_uri)
    found = _first(folder, spellings)
    if found is not None:
        return found
    rooted = [spelling for spelling in spellings if is_file_uri or _ROOT.match(spelling)]
    if not rooted:
        raise RefletError(f"{shown} is not in {folder}, in capitals or small letters; copy it there.")
    endings = [_components(spelling) for spelling in rooted]
    for length in range(max(map(len, endings)), 0, -1):
        found = _first(folder, ["/".join(parts[-length:]) for parts in endings if len(parts) >= length])
        if found is not None:
            return found
    last = [parts[-1] for parts in endings if parts]
    found = _first(folder, [f"textures/{part}" for part in last])
    if found is not None:
        return found
    wanted = _shown(last[0]) if last else shown
    raise RefletError(
        f"{shown} is not on this machine, and {wanted} neither in {folder} nor in its folder textures; copy it there."
    )


def _shown(name: str) -> str:
    """The name as a sentence may repeat it: short, and printable where it is no Unicode."""
    printable = name.encode("utf-8", "backslashreplace").decode("utf-8")
    return printable if len(printable) <= 120 else printable[:120] + "…"


def _spellings(name: str, is_uri: bool) -> list[str]:
    """What the name may stand for, the most likely first."""
    bare = name.strip()
    if len(bare) > 1 and bare[0] == bare[-1] and bare[0] in "\"'":
        bare = bare[1:-1]
    if bare.lower().startswith("file:"):
        bare = bare[5:].removeprefix("//").removeprefix("localhost")
        bare = re.sub(r"^/(?=[A-Za-z]:)", "", bare)
    cut = re.split(r"[?#]", bare, maxsplit=1)[0]
    plain, escaped = [name, bare], [_unescaped(cut), _unescaped(bare)]
    order = [*escaped, *plain, cut] if is_uri else [*plain, escaped[1], cut, escaped[0]]
    return list(dict.fromkeys(spelling for spelling in order if spelling.strip()))


def _unescaped(text: str) -> str:
    return unquote(text, errors="surrogateescape")


def _components(spelling: str) -> list[str]:
    parts = re.split(r"[\\/]+", _ROOT.sub("", spelling, count=1) if _ROOT.match(spelling) else spelling)
    return [part for part in parts if part not in ("", ".")]


def _first(folder: Path, spellings: list[str]) -> Path | None:
    """The first spelling that is a file exactly, else the first one that is a file but for the form of its letters."""
    for spelling in spellings:
        for exact in (spelling, spelling.replace("\\", "/")):
            if os.path.isfile(folder / exact):
                return folder / exact
    for spelling in spellings:
        matches = [] if _ROOT.match(spelling) else _loose_matches(folder, _components(spelling))
        if len(matches) > 1:
            names = ", ".join(map(str, matches))
            raise RefletError(
                f"{_shown(spelling)} may be any of {names}; rename the one that is meant to exactly that."
            )
        if matches:
            return matches[0]
    return None


def _loose_matches(folder: Path, parts: list[str]) -> list[Path]:
    """Files under ``folder`` whose names equal ``parts`` but for the form of letters; exact folders go first."""
    if not parts:
        return [folder] if os.path.isfile(folder) else []
    head, rest = parts[0], parts[1:]
    entries = [head] if head == ".." else _listing(folder)
    exact = [match for entry in entries if entry == head for match in _loose_matches(folder / entry, rest)]
    alike = [entry for entry in entries if entry != head and _letters(entry) == _letters(head)]
    return exact or [match for entry in alike for match in _loose_matches(folder / entry, rest)]


def _listing(folder: Path) -> list[str]:
    try:
        return sorted(os.listdir(folder))
    except (OSError, ValueError):
        return []


def _letters(name: str) -> str:
    """The same for names that differ in case, in Unicode's form or in the encoding of their letters only."""
    as_latin_1 = re.sub("[\udc80-\udcff]", lambda byte: chr(ord(byte[0]) - 0xDC00), name)  # bytes that are no UTF-8
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", as_latin_1).casefold())
