"""What gathering the outcomes of a population costs, from one host to a thousand.

    python scripts/gather_cost.py

Measures on this machine what a host pays for each byte and each message over loopback, and puts the
figures into a ring all-gather, with hosts that are late as exponential waiting times make them.
"""

import argparse
import socket
import threading
import time

import numpy as np

OUTCOME_BYTES = 8 * 4  # a walker's outcome: eight numbers of four bytes
NETWORK = 10e9 / 8  # bytes/s: a host's link in a cluster without anything special
NETWORK_LATENCY = 50e-6  # s: from one host to the next, through a switch or two
HOSTS = (1, 2, 10, 100, 1000)


def measure_loopback(num_bytes: int = 1 << 24, messages: int = 200) -> tuple[float, float]:
    """Returns s for each byte and s for each message, there and back, between two threads."""
    one, other = socket.socketpair()

    def answer() -> None:
        received = 0
        while received < num_bytes:
            received += len(other.recv(1 << 20))
        other.sendall(b"1")
        for _ in range(messages):
            other.sendall(other.recv(1))

    thread = threading.Thread(target=answer)
    thread.start()
    started = time.perf_counter()
    one.sendall(bytes(num_bytes))
    one.recv(1)
    of_byte = (time.perf_counter() - started) / num_bytes
    started = time.perf_counter()
    for _ in range(messages):
        one.sendall(b"1")
        one.recv(1)
    of_message = (time.perf_counter() - started) / messages / 2
    thread.join()
    one.close()
    other.close()
    return of_byte, of_message


def gather(hosts: int, walkers: int, of_byte: float, of_message: float) -> float:
    """Returns s that a ring all-gather takes: each host passes on hosts - 1 parts."""
    part = -(-walkers // hosts) * OUTCOME_BYTES
    return (hosts - 1) * (of_message + part * of_byte)


def lateness(hosts: int, evaluate_s: float, spread: float, random: np.random.Generator) -> float:
    """Returns s by which the last host is behind the mean one, averaged over generations."""
    times = evaluate_s * (1 - spread + random.exponential(spread, (2000, hosts)))
    return float(np.mean(times.max(axis=1)) - evaluate_s)


def main() -> None:
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--walkers", type=int, default=1_000_000, help="of a generation")
    parser.add_argument("--trials-per-s", type=float, default=2_000.0, help="that a host evaluates")
    parser.add_argument("--spread", type=float, default=0.05, help="of a host's time, as a share")
    asked = parser.parse_args()
    # The least of many: whatever else the machine does only adds.
    of_byte, of_message = np.min([measure_loopback() for _ in range(50)], axis=0)
    print(f"loopback here: {1e-9 / of_byte:.2f} GB/s, {of_message * 1e6:.0f} us a message")
    of_byte = max(of_byte, 1 / NETWORK)
    of_message += NETWORK_LATENCY
    random = np.random.default_rng(0)
    print("| hosts | evaluating, s | gathering, ms | waiting for the last, ms | efficiency |")
    print("| ---: | ---: | ---: | ---: | ---: |")
    for hosts in HOSTS:
        evaluate = asked.walkers / hosts / asked.trials_per_s
        gathering = gather(hosts, asked.walkers, of_byte, of_message)
        waiting = lateness(hosts, evaluate, asked.spread, random)
        efficiency = evaluate / (evaluate + gathering + waiting)
        print(
            f"| {hosts} | {evaluate:.2f} | {gathering * 1e3:.0f} | {waiting * 1e3:.0f} "
            f"| {efficiency:.0%} |"
        )


if __name__ == "__main__":
    main()
