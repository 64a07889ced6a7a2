"""A PEM's folder, which any static web host can serve: writing, opening. FORMAT.md describes it."""

from reflet.pem.reader import open_pem
from reflet.pem.writer import PemWriter, save_pem

__all__ = ["PemWriter", "open_pem", "save_pem"]
