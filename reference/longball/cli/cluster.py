"""Work on a Dask cluster in place of this machine's cores, by joblib's backend."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from importlib import import_module
from typing import Any

from longball import __version__
from longball.cli.messages import fail, wrong_call
from longball.cli.options import Options

# Timeouts, s, for the scheduler and for its workers. A wrong address must fail before a user gives
# up.
CONNECTING = 5.0
PROBING = 8.0


@contextmanager
def on_cluster(o: Options) -> Iterator[int]:
    """Run joblib's tasks within this context on a cluster, by --scheduler, or on this machine.

    It yields the number of workers to ask for, which is that of --workers here, and all of them on
    a cluster.

    Tasks, their order and the results are the same, to the last bit. If a worker is lost, another
    one repeats its task; if all are lost, the run waits for new ones.
    """
    if o.scheduler is None:
        yield o.workers
        return
    address = str(o.scheduler)
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        wrong_call('--scheduler: Dask is not installed; pip install ".[dask]"')
    # The engines ask joblib for workers: its backend decides where these are.
    from joblib import parallel_config

    option = f"--scheduler {address}"
    try:
        # Parse the address first: a client rejects an invalid one late, with a traceback.
        distributed.comm.get_address_host_port(address, strict=True)
        certificates = distributed.Security().get_connection_args("client")["ssl_context"]
        if address.startswith("tls:") and certificates is None:
            wrong_call(f"{option}: Dask's configuration has no certificates, distributed.comm.tls")
        client = distributed.Client(address, timeout=CONNECTING, set_as_default=False)
    except ValueError as error:
        wrong_call(f"{option}: an address is tcp://HOST:PORT or tls://HOST:PORT: {error}")
    except OSError as error:
        wrong_call(f"{option}: no scheduler can be reached there: {error}")
    with client:
        _check_workers(client, option)
        with parallel_config("dask", client=client):
            try:
                yield -1
            except (distributed.KilledWorker, CancelledError) as error:
                fail(f"{option}: the cluster gave up: {error}")


def _check_workers(client: Any, option: str) -> None:
    """Refuse a cluster without workers, or with other code on them than here."""
    from longball.golden.writer import fingerprint

    try:
        client.wait_for_workers(1, timeout=PROBING)
        theirs = client.run(fingerprint)
    except TimeoutError:
        wrong_call(f"{option}: it has no workers, or none that answers within {PROBING:g} s")
    except (ImportError, AttributeError):
        wrong_call(f"{option}: its workers have no longball, or another version of it")
    # Other code or libraries could change the last bits of the results.
    ours = fingerprint()
    if others := [worker for worker, code in theirs.items() if code != ours]:
        wrong_call(
            f"{option}: {len(others)} of {len(theirs)} workers have other code than this longball "
            f"{__version__}, or other versions of its libraries, among them {min(others)}"
        )
