"""Where jobs run: on a Dask cluster that is there, on one made for the occasion, or here, one after the other."""

import contextlib
import sys
import uuid

import diagnosis_jobs

CONNECT_S = 30  # patience with a scheduler that does not answer
PATIENCE_S = 30  # until it is asked whether anybody is left who works


class NoWorkers(Exception):
    """Nobody is left to do the rest."""


def run_all(jobs, options):
    """One `Outcome` per job, in the order of the jobs. Progress goes to standard error, if that is a terminal."""
    tell = Progress(len(jobs))
    if options.here:
        return [tell(diagnosis_jobs.run(job)) for job in jobs]
    outcomes = {}
    while left := [job for job in jobs if job.name not in outcomes]:
        try:
            with client(options) as connected:
                outcomes.update((outcome.name, outcome) for outcome in on_dask(connected, left, tell))
        except Exception:  # a cluster that does not end cleanly, a worker of which was killed, costs no outcome; the rest is done by another
            if len(left) + len(outcomes) == len(jobs):
                raise
    return [outcomes[job.name] for job in jobs]


@contextlib.contextmanager
def client(options):
    """A client of the scheduler named, or of a cluster of processes on this machine, which ends with it."""
    from distributed import Client, LocalCluster

    if options.scheduler:
        with Client(options.scheduler, timeout=CONNECT_S) as connected:
            yield connected
    else:
        with (
            LocalCluster(n_workers=options.workers, threads_per_worker=1, dashboard_address=None) as cluster,
            Client(cluster) as connected,
        ):
            yield connected


def on_dask(connected, jobs, tell):
    """Outcomes as they come. A task that dies (with a worker out of memory, say) is a failed job, not the end."""
    connected.upload_file(diagnosis_jobs.__file__)  # to the workers, those that join later as well
    # A key of its own for every call: a job that failed is tried again, and two people with jobs of the same name do not meet.
    call = uuid.uuid4().hex
    futures = {connected.submit(diagnosis_jobs.run, job, key=f"{job.name}-{call}", pure=False): job for job in jobs}
    while futures:
        ended = {future: outcome_of(future, futures[future]) for future in first_ended(futures)}
        outcomes = {future: outcome for future, outcome in ended.items() if outcome}
        if not outcomes and connected.cluster and not workers_come(connected):  # to a scheduler of somebody else they may come later
            raise NoWorkers(f"no worker is left for {len(futures)} jobs")
        for future, outcome in outcomes.items():
            del futures[future]
            yield tell(outcome)


def workers_come(connected):
    """Whether there are workers, or those killed are there again soon."""
    try:
        connected.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError:
        return False
    return True


def first_ended(futures):
    """Those that have ended, as soon as one has; none where that takes long."""
    from distributed import wait

    try:
        return wait(list(futures), timeout=PATIENCE_S, return_when="FIRST_COMPLETED").done
    except TimeoutError:
        return ()


def outcome_of(future, job):
    """How the job of a future that ended did; none where that was lost with its worker, and the job is done again."""
    if future.status != "finished":
        return diagnosis_jobs.Outcome(job.name, "failed", f"the task ended as {future.status}: {future.exception()!r}")
    try:
        return future.result(timeout=PATIENCE_S)
    except TimeoutError:
        return None


class Progress:
    """`[3/12] name: finished` on a terminal, nothing elsewhere."""

    def __init__(self, count):
        self.count, self.done = count, 0

    def __call__(self, outcome):
        self.done += 1
        if sys.stderr.isatty():
            reason = f", {outcome.reason}" if outcome.reason else ""
            print(f"[{self.done}/{self.count}] {outcome.name}: {outcome.ended}{reason}", file=sys.stderr)
        return outcome
