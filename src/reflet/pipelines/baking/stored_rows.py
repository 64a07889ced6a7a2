"""Rows of many viewpoints on disk while a bake runs, from where the solver reads them block by block."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from reflet.infer.records import RenderingMatrix, Rows
from reflet.pem.writer import PemWriter


@dataclass(frozen=True)
class StoredRows(Collection[Rows]):
    """Rows in a writer's state under some names, read whenever they are asked for."""

    writer: PemWriter
    names: list[str]
    texel_count: int

    def __len__(self) -> int:
        return len(self.names)

    def __contains__(self, rows: object) -> bool:
        return any(rows is each for each in self)

    def __iter__(self) -> Iterator[Rows]:
        for name in self.names:
            state = self.writer.load_state(name)
            assert state is not None
            yield Rows(
                RenderingMatrix(state["starts"], state["columns"], state["shares"], self.texel_count),
                state["target"],
                state["weights"],
            )


def row_arrays(rows: Rows) -> dict[str, Any]:
    """What is stored of them."""
    return {
        "starts": rows.matrix.starts,
        "columns": rows.matrix.columns,
        "shares": rows.matrix.weights,
        "target": rows.target,
        "weights": rows.weights,
    }
