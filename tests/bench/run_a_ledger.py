"""A benchmark run of its own process, for the tests that kill it.

python run_a_ledger.py RESULT LOG [--restart] [--gain G] [--fatal KEY]
"""

from __future__ import annotations

import argparse
import math
import os
import time
from pathlib import Path

from brdfit.bench.ledger import Ledger, figure
from brdfit.bench.workers import Task


def work(shared, task):
    time.sleep(0.01)
    if task.key == shared["fatal"]:
        os._exit(9)
    with open(shared["log"], "a", encoding="utf-8") as log:
        log.write(task.key + "\n")
    number = task.payload
    return [
        {"key": f"{task.key}/{part}", "value": figure(math.sin(number * shared["gain"] + part))}
        for part in range(3)
    ]


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("result", type=Path)
    parser.add_argument("log")
    parser.add_argument("--restart", action="store_true")
    parser.add_argument("--gain", type=float, default=1.0)
    parser.add_argument("--fatal", default="")
    arguments = parser.parse_args()
    shared = {"log": arguments.log, "gain": arguments.gain, "fatal": arguments.fatal}
    ledger = Ledger(
        arguments.result,
        {"benchmark": "test", "settings": {"gain": arguments.gain}},
        restart=arguments.restart,
        workers=2,
    )
    tasks = [Task(f"task{number:03d}", number) for number in range(60)]
    ledger.run(tasks, work, lambda left: shared, say=print)


if __name__ == "__main__":
    main()
