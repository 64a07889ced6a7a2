"""Files that scene files refer to, by names as tools write them."""

import os
import unicodedata

import pytest

from reflet.errors import RefletError
from reflet.scene.readers.resources import find_resource


def put(folder, *names):
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(os.fsencode(name))


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("tex.png", "tex.png"),
        ("./tex.png", "tex.png"),
        (".\\maps\\tex.png", "maps/tex.png"),
        ("maps\\sub/tex.png", "maps/sub/tex.png"),
        ("TEX.PNG", "tex.png"),
        ("maps/Tex.Png", "Maps/tEX.png"),
        ("..\\Common\\tex.png", "../common/tex.png"),
        ("my tex.png", "my tex.png"),
        ('"my tex.png"', "my tex.png"),
        (" tex.png ", "tex.png"),
        ("my%20tex.png", "my tex.png"),
        ("my%20tex.png", "my%20tex.png"),
        ("tex.png?v=3", "tex.png"),
        ("tex.png#part", "tex.png"),
        ("what?.png", "what?.png"),
        ("file:tex.png", "tex.png"),
        ("file://tex.png", "tex.png"),
        ("file:///C:/Users/x/my%20tex.png", "my tex.png"),
        ("file://localhost/home/x/tex.png", "tex.png"),
        ("file:///home/x/maps/tex.png", "maps/tex.png"),
        ("C:\\Users\\x\\tex.png", "tex.png"),
        ("C:\\Users\\x\\Maps\\TEX.png", "maps/tex.png"),
        ("C:tex.png", "tex.png"),
        ("\\\\server\\share\\tex.png", "tex.png"),
        ("/home/nobody/here/tex.png", "tex.png"),
        ("/home/nobody/here/tex.png", "Textures/tex.png"),
        ("Maya:tex.png", "Maya:tex.png"),
        (unicodedata.normalize("NFC", "Möbel.png"), unicodedata.normalize("NFD", "Möbel.png")),
        (unicodedata.normalize("NFD", "MÖBEL.png"), unicodedata.normalize("NFC", "möbel.png")),
        (os.fsdecode("möbel.png".encode("latin-1")), "möbel.png"),
        ("möbel.png", os.fsdecode("möbel.png".encode("latin-1"))),
    ],
)
@pytest.mark.parametrize("is_uri", [False, True])
def test_found_as_a_browser_or_a_windows_user_would_find_it(tmp_path, name, file, is_uri):
    folder = tmp_path / "model"
    folder.mkdir()
    put(folder, file, "other.png", "maps/other.png")
    assert find_resource(folder, name, is_uri=is_uri).samefile(folder / file)


def test_absolute_names_of_this_machine_stay(tmp_path):
    put(tmp_path, "here/a b.png", "model/a b.png")
    assert find_resource(tmp_path / "model", str(tmp_path / "here/a b.png")) == tmp_path / "here/a b.png"
    uri = (tmp_path / "here/a b.png").as_uri()
    assert find_resource(tmp_path / "model", uri, is_uri=True) == tmp_path / "here/a b.png"


def test_the_exact_name_goes_first(tmp_path):
    put(tmp_path, "a%20b.png", "a b.png", "Tex.png", "tex.png", "x/TEX.png", "X/tex.png", "q.png", "q.png?v=1")
    assert find_resource(tmp_path, "a%20b.png").name == "a%20b.png"
    assert find_resource(tmp_path, "a%20b.png", is_uri=True).name == "a b.png"  # what the URI says
    assert find_resource(tmp_path, "q.png?v=1").name == "q.png?v=1"
    assert find_resource(tmp_path, "q.png?v=1", is_uri=True).name == "q.png"
    assert find_resource(tmp_path, "Tex.png").name == "Tex.png"
    assert find_resource(tmp_path, "x/tex.png") == tmp_path / "x/TEX.png"  # the folder that is named exactly


def test_of_several_absolute_endings_the_longest_goes_first(tmp_path):
    put(tmp_path, "tex.png", "a/tex.png", "textures/tex.png")
    assert find_resource(tmp_path, "D:\\work\\a\\tex.png") == tmp_path / "a/tex.png"
    assert find_resource(tmp_path, "D:\\work\\b\\tex.png") == tmp_path / "tex.png"


def test_names_that_several_files_have_are_refused(tmp_path):
    put(tmp_path, "Tex.png", "tex.png")
    with pytest.raises(RefletError, match=r"TEX.png may be any of .*Tex.png, .*tex.png; rename"):
        find_resource(tmp_path, "TEX.png")


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("maps/none.png", "maps/none.png is not in .*, in capitals or small letters; copy it there."),
        ("C:\\x\\none.png", "none.png is not on this machine, and none.png neither in .* nor in its folder textures"),
        ("https://example.org/none.png", "https://example.org/none.png is on the network; download it"),
        ("HTTP://example.org/tex.png", "is on the network"),
        ("", "is not in"),
        ("/", "is not on this machine"),
        ("maps", "maps is not in"),  # a folder
        ("tex.png/x", "is not in"),
        ("nul\0.png", "is not in"),
        ("half\ud800\udc80.png", "is not in"),
        ("long" * 2000, "longlong.*…"),
    ],
)
def test_what_is_not_there_is_said(tmp_path, name, sentence):
    put(tmp_path, "tex.png", "maps/tex.png")
    for is_uri in (False, True):
        with pytest.raises(RefletError, match=sentence) as caught:
            find_resource(tmp_path, name, is_uri=is_uri)
        str(caught.value).encode("utf-8")  # can be printed
        assert len(str(caught.value)) < 600


def test_files_that_carry_the_wrong_end_are_not_taken(tmp_path):
    """Only absolute names are looked for by their end: a relative one says which folder it means."""
    put(tmp_path, "tex.png")
    with pytest.raises(RefletError):
        find_resource(tmp_path, "maps/tex.png")
