"""The page as a user has it, for tests and benchmarks: ``autobalancer app`` in a process of its own, and a real Chromium."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from pathlib import Path

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
ARGUMENTS += ["--disable-gpu-compositing"]  # else all that moves on a page is drawn by the emulated graphics card, too
PATIENCE = 3000  # tenths of a second until it listens, on a machine that others have, too


def free_port() -> int:
    """A port at which nobody listens now."""
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


class Server:
    """The command ``autobalancer app``, started as a user starts it; it listens when this returns."""

    def __init__(self, folder: Path, *words: str) -> None:
        self.folder, self.port, self.words = folder, free_port(), words
        self.address = f"http://127.0.0.1:{self.port}/"
        self.start()

    def start(self) -> None:
        """Start it, also once more after :meth:`stop`."""
        words = ["app", "--port", str(self.port), "--folder", str(self.folder), "--no-browser", *self.words]
        alone = {
            name: value for name, value in os.environ.items() if "PYTEST" not in name
        }  # NiceGUI tests itself with it
        self.process = subprocess.Popen([sys.executable, "-m", "autobalancer", *words], env=alone)
        for _ in range(PATIENCE):
            with socket.socket() as one:
                if one.connect_ex(("127.0.0.1", self.port)) == 0:
                    return
            if self.process.poll() is not None:
                raise RuntimeError(f"the server ended with {self.process.returncode}")
            time.sleep(0.1)
        raise RuntimeError("the server does not answer")

    def stop(self) -> None:
        """End it as Ctrl-C does."""
        self.process.terminate()
        self.process.wait(120)
