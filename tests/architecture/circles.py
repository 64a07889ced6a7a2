"""Circles among imports, for the tests here."""


def circle(imports: dict[str, set[str]]) -> list[str]:
    """Names that import each other in a circle, the first one again at the end; empty where there is none."""
    done: set[str] = set()

    def visit(name: str, way: list[str]) -> list[str]:
        if name in way:
            return [*way[way.index(name) :], name]
        if name in done:
            return []
        found = next((found for next_ in sorted(imports.get(name, ())) if (found := visit(next_, [*way, name]))), [])
        done.add(name)
        return found

    return next((found for name in sorted(imports) if (found := visit(name, []))), [])
