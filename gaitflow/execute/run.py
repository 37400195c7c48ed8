"""Running a plan to its end on any Dask cluster: list the store, submit what is missing, a bounded window at a time.

Only receipts travel; a worker stores what it solved. So whatever dies, a worker, the scheduler or this process,
the next run finds every finished unit in the store and solves none of them again.
"""

from __future__ import annotations

import json
import random
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, suppress
from queue import Empty, SimpleQueue

from distributed import Client, Future, KilledWorker

from gaitflow.execute.count import Count, OnEvent, RunState
from gaitflow.execute.receipt import Receipt
from gaitflow.execute.solver import SolverClosed
from gaitflow.execute.solver_process import SOLVE
from gaitflow.execute.stop_request import stop_request
from gaitflow.execute.worker import SolverPlugin, solve_unit
from gaitflow.store.known_parts import validate_changed
from gaitflow.store.leftovers import remove_leftovers
from gaitflow.store.lost_workers import give_up_after_lost_workers
from gaitflow.store.parts import UnitStore
from gaitflow.store.units import Unit

UNITS_PER_WORKER = 3  # submitted at a time: one in work, the next at hand
POLL_S = 0.3  # how often a wait looks for a request to stop, and how many workers there are
REGISTRATIONS = 20  # tries to set up the workers while some of them die
MAX_ROUNDS = 4  # of solving parts again that turned out damaged


class RunStopped(KeyboardInterrupt):
    """The user stopped the run, by Ctrl-C or SIGTERM; the message says what is done and how to go on."""


class RunFailed(Exception):
    """The run cannot go on; the message says why and what to do. Finished units are kept."""


OpenClient = Callable[[], AbstractContextManager[Client]]


def run_units(
    units: Sequence[Unit],
    store: UnitStore,
    open_client: OpenClient,
    on_event: OnEvent = lambda state: None,
    window: int | None = None,
    solve: str = SOLVE,
) -> RunState:
    """Solve every unit that the store lacks, then check all new parts and solve damaged ones again.

    Parts that an earlier run found sound, in files that did not change since, are not read again; `collect` reads all.
    `open_client` makes a cluster and a client for the length of a block, such as `local_client`; it is not called
    when nothing is missing. `window` bounds the units submitted at a time (default: 3 a worker). `on_event` hears of
    every change. A `stop_request` ends the run cleanly with RunStopped, also while the cluster starts or closes.
    Raises RunFailed when no unit can be stored, or when no worker will come any more.
    """
    remove_leftovers(store.folder)
    notes = [f"damaged pack, its units will be solved again: {reason}" for reason in store.set_aside_damaged_packs()]
    for _ in range(MAX_ROUNDS):
        stored = store.solved()
        failed = store.attempts.given_up() & stored
        missing = [unit for unit in units if unit.digest not in stored]
        count = Count(units, stored, failed, store.folder / "journal", on_event)
        if notes:
            count.tell(*notes)
        if missing:
            # In random order the time left is estimated from a fair sample, and two runs on one store seldom meet.
            random.shuffle(missing)
            begun = store.begun()
            missing.sort(key=lambda unit: unit.digest not in begun)
            give_up_after_lost_workers(store, missing)
            with stop_request() as stop:
                try:
                    with open_client() as client:
                        _drain(missing, store, client, count, stop, window, solve)
                except Exception:
                    if not stop.is_set():  # otherwise the cluster's processes may have heard it, too, and be gone
                        raise
            if stop.is_set():  # whoever called us may have more to do, even if all units are stored
                raise RunStopped(f"stopped: {_how_far(count.state, store)}")
        damaged = validate_changed(store, units)
        if not damaged:
            return count.state
        notes = [f"damaged part, will be solved again: {reason}" for reason in damaged.values()]
    raise RunFailed(f"{store.folder}: parts were damaged {MAX_ROUNDS} times in a row; check that disk")


def _how_far(state: RunState, store: UnitStore) -> str:
    stored = f"{state.total - state.left} of {state.total} units are stored in {store.folder}"
    return f"{stored}; run the same command again to go on"


def _drain(
    missing: list[Unit],
    store: UnitStore,
    client: Client,
    count: Count,
    stop: threading.Event,
    window: int | None,
    solve: str,
) -> None:
    _give_solvers(client, solve)
    queue = missing[::-1]
    flying: dict[Future[Receipt], Unit] = {}
    ended: SimpleQueue[Future[Receipt]] = SimpleQueue()
    room, next_count = 0, 0.0
    while (queue or flying) and not stop.is_set():
        if hopeless := getattr(client.cluster, "hopeless", ""):  # of a pool of jobs, see `pool`
            raise RunFailed(f"{hopeless}: {_how_far(count.state, store)}")
        if time.monotonic() >= next_count:
            room = window or UNITS_PER_WORKER * max(1, len(client.nthreads()))
            next_count = time.monotonic() + POLL_S
        if batch := [queue.pop() for _ in range(min(len(queue), room - len(flying)))]:
            flying |= _submit(batch, store, client, ended)
        done = _ended(ended)
        receipts = _receipts(client, done)
        killed = []
        for future in done:
            unit = flying.pop(future)
            receipt = receipts.get(unit.digest)
            if receipt is None:
                _check_worker(future)
                queue.append(unit)
                if future.status == "error" and isinstance(future.exception(), KilledWorker):
                    killed.append(unit)
            elif receipt.outcome == "refused":
                raise RunFailed(receipt.error)
            else:
                count.add(receipt)
        count.look()
        if killed:
            give_up_after_lost_workers(store, killed)


def _submit(
    units: Sequence[Unit], store: UnitStore, client: Client, ended: SimpleQueue[Future[Receipt]]
) -> dict[Future[Receipt], Unit]:
    """Hand out units; each of the futures goes into `ended` when it has come to its end."""
    folder = str(store.folder.resolve())
    texts = [json.dumps(unit.as_data()) for unit in units]
    # Not pure: a unit that is submitted again must not be answered by what Dask remembers of it.
    futures: list[Future[Receipt]] = client.map(solve_unit, texts, folder=folder, pure=False)
    for future in futures:
        future.add_done_callback(ended.put)
    return dict(zip(futures, units, strict=True))


def _give_solvers(client: Client, solve: str) -> None:
    """Have every worker, present and to come, drive a solver process.

    A worker that dies just now breaks the call, though its successor will be given the plugin: then once more.
    """
    for _ in range(REGISTRATIONS):
        try:
            client.register_plugin(SolverPlugin(solve))
            return
        except OSError as error:  # CommClosedError is one
            last = error
            time.sleep(POLL_S)
    raise RunFailed(f"workers cannot be set up ({last}); the cluster seems to go down again and again") from last


def _ended(ended: SimpleQueue[Future[Receipt]]) -> list[Future[Receipt]]:
    """All futures that have come to their end by now, after waiting a moment for the first one."""
    found = []
    with suppress(Empty):
        found.append(ended.get(timeout=POLL_S))
        while True:
            found.append(ended.get_nowait())
    return found


def _receipts(client: Client, futures: Sequence[Future[Receipt]]) -> dict[str, Receipt]:
    """What finished tasks returned, by unit: fetched at once, as a round trip each would bound the rate of a run."""
    finished = [future for future in futures if future.status == "finished"]
    found = client.gather(finished, errors="skip") if finished else []
    return {receipt.unit: receipt for receipt in found if isinstance(receipt, Receipt)}


def _check_worker(future: Future[Receipt]) -> None:
    """Raise RunFailed for a task without a receipt, unless its worker went away, and its unit is submitted again."""
    error = future.exception() if future.status == "error" else None
    if error is not None and not isinstance(error, SolverClosed | KilledWorker):
        raise RunFailed(f"a worker cannot run units ({type(error).__name__}: {error})") from error
