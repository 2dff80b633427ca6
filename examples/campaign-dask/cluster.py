"""Where jobs run: on an existing Dask cluster, on a temporary one, or sequentially in this process."""

import contextlib
import sys
import uuid

import diagnosis_jobs

CONNECT_S = 30  # timeout for a scheduler that does not answer
PATIENCE_S = 30  # interval between checks for live workers


class NoWorkers(Exception):
    """No worker is left for the remaining jobs."""


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
        except Exception:  # a cluster that does not shut down cleanly because a worker was killed loses no outcome; another one does the remaining jobs
            if len(left) + len(outcomes) == len(jobs):
                raise
    return [outcomes[job.name] for job in jobs]


@contextlib.contextmanager
def client(options):
    """A client of the given scheduler, or of a cluster of local processes, which is shut down with it."""
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
    """Outcomes in order of completion. A task that dies (e.g. with a worker out of memory) is a failed job; the others continue."""
    connected.upload_file(diagnosis_jobs.__file__)  # to the workers, including those that join later
    # A unique key for every call: a failed job is retried, and jobs of the same name from two users do not collide.
    call = uuid.uuid4().hex
    futures = {connected.submit(diagnosis_jobs.run, job, key=f"{job.name}-{call}", pure=False): job for job in jobs}
    while futures:
        ended = {future: outcome_of(future, futures[future]) for future in first_ended(futures)}
        outcomes = {future: outcome for future, outcome in ended.items() if outcome}
        if not outcomes and connected.cluster and not workers_come(connected):  # on a shared scheduler they may join later
            raise NoWorkers(f"no worker is left for {len(futures)} jobs")
        for future, outcome in outcomes.items():
            del futures[future]
            yield tell(outcome)


def workers_come(connected):
    """Whether there are workers, or killed ones are restarted soon."""
    try:
        connected.wait_for_workers(1, timeout=PATIENCE_S)
    except TimeoutError:
        return False
    return True


def first_ended(futures):
    """The finished futures, as soon as there is one; none after a timeout."""
    from distributed import wait

    try:
        return wait(list(futures), timeout=PATIENCE_S, return_when="FIRST_COMPLETED").done
    except TimeoutError:
        return ()


def outcome_of(future, job):
    """Outcome of the job of a finished future; none if it was lost with its worker and the job is repeated."""
    if future.status != "finished":
        return diagnosis_jobs.Outcome(job.name, "failed", f"the task ended as {future.status}: {future.exception()!r}")
    try:
        return future.result(timeout=PATIENCE_S)
    except TimeoutError:
        return None


class Progress:
    """`[3/12] name: finished` on a terminal, otherwise nothing."""

    def __init__(self, count):
        self.count, self.done = count, 0

    def __call__(self, outcome):
        self.done += 1
        if sys.stderr.isatty():
            reason = f", {outcome.reason}" if outcome.reason else ""
            print(f"[{self.done}/{self.count}] {outcome.name}: {outcome.ended}{reason}", file=sys.stderr)
        return outcome
