"""Runs cases on this machine, one thread each, by joblib's pool of processes."""

import collections
import concurrent.futures

from joblib.externals.loky import get_reusable_executor
from joblib.externals.loky.process_executor import BrokenProcessPool

from sweeping.cases import Case, fail, run_case

# A case whose worker dies this many times counts as failed.
MOST_ATTEMPTS = 3

# Cases in the pool for each worker: enough that no worker is idle, few enough to lose little if the pool breaks.
AHEAD = 4


def run_here(program, plan, store, numbers, jobs, progress):
    """Runs the cases with these numbers, and calls progress(result) for each."""
    waiting = collections.deque(numbers)
    attempts = collections.Counter()
    running = {}

    def submit(pool):
        while waiting and len(running) < AHEAD * jobs:
            number = waiting[0]
            is_suspect = attempts[number] == MOST_ATTEMPTS - 1  # the last attempt runs alone
            if is_suspect and running:
                return
            waiting.popleft()
            attempts[number] += 1
            running[pool.submit(run_case, Case(program, plan, number), store)] = number
            if is_suspect:
                return

    while waiting or running:
        pool = get_reusable_executor(max_workers=jobs, timeout=60)
        try:
            submit(pool)
            while running:
                done, _ = concurrent.futures.wait(
                    running, return_when=concurrent.futures.FIRST_COMPLETED)
                for future in done:
                    result = future.result()
                    del running[future]
                    if result is None:
                        raise KeyboardInterrupt
                    progress(result)
                submit(pool)
        except BrokenProcessPool:
            # A worker was killed: all running cases start again.
            done, again = store.done(), []
            for number in running.values():
                if number in done:
                    progress(store.result(number))
                elif attempts[number] == MOST_ATTEMPTS:
                    progress(fail(Case(program, plan, number), store,
                                  "its worker was killed %d times" % MOST_ATTEMPTS))
                else:
                    again.append(number)
            running.clear()
            waiting.extendleft(reversed(again))
