"""A progress bar with rate and time left, on terminals only."""

import sys
import time


class Progress:
    WIDTH = 30

    def __init__(self, total):
        self.total, self.count, self.failed = total, 0, 0
        self.begin = time.monotonic()
        self.next = 0.0
        self.on_terminal = sys.stderr.isatty()

    def add(self, result):
        if result["status"] != "done":
            self.failed += 1
            line = result["message"].splitlines() or [""]
            self.tell("sweep: case %d %s: %s" % (result["case"], result["status"], line[-1]))
        self.set(self.count + 1)

    def set(self, count):
        self.count = count
        now = time.monotonic()
        if not self.on_terminal or now < self.next:
            return
        self.next = now + 0.1
        share = count / max(self.total, 1)
        rate = count / max(now - self.begin, 1e-9)
        left = (self.total - count) / rate if rate > 0 else 0
        filled = int(share * self.WIDTH)
        sys.stderr.write("\r[%s%s] %d/%d  %.1f a second  %.0f s left  %d failed\033[K" % (
            "#" * filled, "-" * (self.WIDTH - filled), count, self.total, rate, left, self.failed))
        sys.stderr.flush()

    def tell(self, line):
        sys.stderr.write(("\r\033[K" if self.on_terminal else "") + line + "\n")

    def close(self):
        if self.on_terminal:
            sys.stderr.write("\r\033[K")

    def seconds(self):
        return time.monotonic() - self.begin
