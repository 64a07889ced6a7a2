"""The search for circles finds them."""

from circles import circle


def test_circles_are_found() -> None:
    assert circle({"a": {"b", "c"}, "b": {"d"}, "c": {"a"}}) == ["a", "c", "a"]
    assert circle({"a": {"b", "c"}, "b": {"c"}}) == []
