"""By which names a server of this machine is asked for, and how else it can be reached.

A page elsewhere may let its own name resolve to an address of this machine, and would then be allowed to read what is
served here. So names are answered to only where they are this machine's own or were given; addresses are no such trick.
"""

import getpass
import ipaddress
import os
import re
import shlex
import socket
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from urllib.parse import urlsplit

from reflet.errors import RefletError

LOOPBACK = "127.0.0.1"
_NAME = re.compile(r"[a-z0-9_]([a-z0-9._-]*[a-z0-9_])?")


@dataclass(frozen=True)
class Hosts:
    """``address`` is listened on; ``names``, in lower case, are answered to, beside localhost and any address."""

    address: str = LOOPBACK
    names: frozenset[str] = frozenset()

    @property
    def is_open(self) -> bool:
        """Whether other machines reach it."""
        return not ipaddress.ip_address(self.address).is_loopback

    @property
    def here(self) -> str:
        """How this machine itself calls it, as URLs have it."""
        address = ipaddress.ip_address(self.address)
        if address.is_unspecified:
            return LOOPBACK if address.version == 4 else "[::1]"
        return self.address if address.version == 4 else f"[{self.address}]"

    def answers(self, header: str) -> bool:
        """Whether a request with this ``Host`` header is answered."""
        host = asked_host(header)
        return host is not None and (
            host == "localhost" or host.endswith(".localhost") or host in self.names or _is_address(host)
        )

    def refusal(self, header: str, port: int) -> str:
        """What those are told who asked by another name: why, and three ways that work."""
        host = asked_host(header)
        name = host if host is not None and _NAME.fullmatch(host) else None
        return (
            f"reflet does not answer requests by {f'the name {name}' if name else 'this name'}: a page elsewhere could "
            "use it to read what is shown here.\n\n"
            f"On this machine, open http://{self.here}:{port}/\n"
            f"From another machine, run {tunnel(self.here, port, name or 'THIS_MACHINE')} and open "
            f"http://localhost:{port}/\n"
            f"If it is the name of a proxy or of this machine, start reflet view again with --host {name or 'NAME'}\n"
        )


def read_hosts(given: Iterable[str]) -> Hosts:
    """Of what is given an address is listened on; names are answered to, and, with an open address, this machine's own.

    Raises RefletError for what is neither and for two addresses.
    """
    given = [host.strip("[]") for host in given]
    addresses = {host for host in given if _is_address(host)}
    names = {host.lower().rstrip(".") for host in given if not _is_address(host)} - {"localhost"}
    for name in names:
        if not _NAME.fullmatch(name):
            raise RefletError(
                f"--host takes a name or an address alone, such as hub.example.org or 0.0.0.0, not {name!r}."
            )
    if len(addresses) > 1:
        both = " and ".join(sorted(addresses))
        raise RefletError(f"One address can be listened on, not {both}; 0.0.0.0 stands for all of this machine's.")
    hosts = Hosts(next(iter(addresses), LOOPBACK), frozenset(names))
    if hosts.is_open:
        own = socket.gethostname().lower()
        hosts = Hosts(hosts.address, frozenset({*names, own, f"{own}.local"}))
    return hosts


def asked_host(header: str) -> str | None:
    """The host in a ``Host`` header, in lower case, without its port; None where there is none."""
    if set(header) & set("/@?#\\ "):
        return None
    try:
        return (urlsplit(f"//{header}").hostname or "").rstrip(".") or None
    except ValueError:
        return None


def tunnel(host: str, port: int, machine: str, *options: str) -> str:
    """The command that makes a port of ``host``, as ``machine`` calls it, one of the machine that it is run on."""
    return shlex.join(["ssh", "-N", "-L", f"{port}:{host}:{port}", *options, machine])


def ways_in(hosts: Hosts, port: int, environment: Mapping[str, str] = os.environ) -> str:
    """How to come here from elsewhere, where somebody seems to want to: one sentence, or none.

    Browsers offer WebGPU to pages over https and from localhost alone, so another machine needs a tunnel either way.
    """
    connection = environment.get("SSH_CONNECTION", "").split()
    if len(connection) == 4:
        options = [] if connection[3] == "22" else ["-p", connection[3]]
        command = tunnel(hosts.here, port, f"{getpass.getuser()}@{connection[2]}", *options)
        return f"On the machine before you, run: {command}\nand open http://localhost:{port}/ there."
    if hosts.is_open:
        command = tunnel(hosts.here, port, socket.gethostname())
        return (
            "Browsers draw pages of other machines over https only (WebGPU). Without a proxy for that, run there: "
            f"{command}\nand open http://localhost:{port}/"
        )
    return ""


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True
