"""Work on a Dask cluster, by joblib's backend, instead of this machine's cores."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from importlib import import_module
from typing import Annotated, Any

import typer

from longball import __version__
from longball.cli.common import tell, wrong_call

CONNECTING = 5.0  # s, until a scheduler that does not answer is given up
PROBING = 60.0  # s, until workers are: a cluster that grows on demand has to start them first

Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Work on the Dask cluster of this scheduler, tcp://HOST:PORT; needs longball[dask].",
    ),
]


@contextmanager
def on_cluster(address: str | None) -> Iterator[None]:
    """Run what joblib runs in this context on a cluster; here, if there is no address.

    The tasks and their order stay the same, and so do the results, to the last bit. A task whose
    worker is lost is done again by another one; if all are lost, the run waits for new ones.
    """
    if address is None:
        yield
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        wrong_call("--scheduler: Dask is not installed; pip install 'longball[dask]'")
    from joblib import parallel_config

    option = f"--scheduler {address}"
    try:
        # A client that cannot make sense of its address takes long to say so, with a traceback.
        distributed.comm.get_address_host_port(address, strict=True)
        certificates = distributed.Security().get_connection_args("client")["ssl_context"]
        if address.startswith("tls:") and certificates is None:
            wrong_call(f"{option}: Dask's configuration has no certificates, distributed.comm.tls")
        client = distributed.Client(address, timeout=CONNECTING, set_as_default=False)
    except ValueError as error:
        wrong_call(f"{option}: an address is tcp://HOST:PORT: {error}")
    except OSError as error:
        wrong_call(f"{option}: no scheduler can be reached there: {error}")
    with client:
        _check_workers(client, option)
        with parallel_config("dask", client=client):
            try:
                yield
            except (distributed.KilledWorker, CancelledError) as error:
                tell(f"{option}: the cluster gave up: {error}")
                raise typer.Exit(1) from None


def _check_workers(client: Any, option: str) -> None:
    """Refuse a cluster without workers, or with other code on them than here."""
    try:
        theirs = client.submit(package_version, pure=False).result(timeout=PROBING)
    except TimeoutError:
        wrong_call(f"{option}: none of its workers answers within {PROBING:g} s")
    except ImportError:
        wrong_call(f"{option}: its workers have no longball")
    if theirs != __version__:
        wrong_call(f"{option}: its workers have longball {theirs}, and this is {__version__}")


def package_version() -> str:
    """Return the version of the package where this is called."""
    return __version__
