"""A real egofocusd for a test: its configuration in a folder of its own, its process, its sockets."""
import argparse
import atexit
import json
import os
import pathlib
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

arguments = None  # --daemon --app --recording --source --cc


def light_recording():
    """The fixture on a coarse grid with few hypotheses: a tick takes little, in a debug build as well."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="egofocusd-light-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    given = pathlib.Path(arguments.recording)
    for name in ("events.raw", "can.log", "vehicle.dbc"):
        os.symlink(given / name, folder / name)
    text = (given / "camera.toml").read_text(encoding="utf-8")
    for key, value in {"hypotheses": "8", "max_events": "4000", "min_events": "100", "smoothing": "false"}.items():
        text, count = re.subn(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
        assert count == 1, key
    grid = "width_px = 60\nheight_px = 45\nfx_px = 50.0\nfy_px = 49.75\ncx_px = 30.0\ncy_px = 21.75\n"
    text, count = re.subn(r"(?<=\[grid\]\n)[^\[]*", grid + "\n", text)
    assert count == 1
    (folder / "camera.toml").write_text(text, encoding="utf-8")
    return str(folder)


class Daemon:
    """options: section__key -> TOML value. The defaults replay a light recording in real time, with the focus backend."""

    light = None

    def __init__(self, folder=None, env=None, **options):
        self.own_folder = folder is None
        self.folder = pathlib.Path(folder or tempfile.mkdtemp(prefix="egofocusd-"))
        self.config = self.folder / "egofocusd.toml"
        self.depth = str(self.folder / "depth.sock")
        self.control = str(self.folder / "control.sock")
        if Daemon.light is None:
            Daemon.light = light_recording()
        self.options = {"source.recording": Daemon.light, "source.at_end": "repeat", "engine.backend": "focus",
                        "engine.rate_hz": 5.0, "depth.socket": self.depth, "control.socket": self.control}
        self.options.update({key.replace("__", "."): value for key, value in options.items()})
        self.write_config()
        self.env = dict(os.environ, **(env or {}))
        self.process = None

    def write_config(self, **changes):
        self.options.update({key.replace("__", "."): value for key, value in changes.items()})
        sections = {}
        for key, value in self.options.items():
            if value is not None:
                section, name = key.split(".")
                sections.setdefault(section, []).append(f"{name} = {json.dumps(value)}")
        self.config.write_text("\n".join(f"[{name}]\n" + "\n".join(lines) for name, lines in sections.items()) + "\n")

    def run(self, *options, **settings):
        return subprocess.run([arguments.daemon, "--config", str(self.config), *options], capture_output=True, text=True,
                              timeout=60, env=self.env, check=False, **settings)

    def start(self, **settings):
        self.log = open(self.folder / "log", "a+", encoding="utf-8")
        self.process = subprocess.Popen([arguments.daemon, "--config", str(self.config)], stderr=self.log, env=self.env,
                                        **settings)
        return self

    def started(self, **settings):
        """Runs, and a tick has come."""
        self.start(**settings)
        wait_for(lambda: self.health().get("ticks_run", 0) > 0, "the first tick: " + self.said())
        return self

    def ask(self, request):
        with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
            client.connect(self.control)
            client.settimeout(10)
            client.sendall(request.encode() + b"\n")
            answer = b""
            while part := client.recv(65536):
                answer += part
        return json.loads(answer)

    def health(self):
        try:
            return self.ask("health")
        except (OSError, ValueError):
            return {}

    def said(self):
        return (self.folder / "log").read_text(encoding="utf-8")

    def stop(self, number=signal.SIGTERM):
        """Exit code and seconds."""
        begin = time.monotonic()
        self.process.send_signal(number)
        code = self.process.wait(timeout=20)
        return code, time.monotonic() - begin

    def close(self):
        if self.process is not None and self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        if self.process is not None:
            self.log.close()
        if self.own_folder:
            shutil.rmtree(self.folder, ignore_errors=True)


def wait_for(condition, what, seconds=20):
    until = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > until:
            raise AssertionError("not in time: " + what)
        time.sleep(0.01)


class DaemonTest(unittest.TestCase):
    def daemon(self, **options):
        daemon = Daemon(**options)
        self.addCleanup(daemon.close)
        return daemon


def main():
    global arguments  # pylint: disable=global-statement
    parser = argparse.ArgumentParser()
    for name in ("daemon", "app", "recording", "source", "cc"):
        parser.add_argument("--" + name, required=True)
    arguments, rest = parser.parse_known_args()
    unittest.main(module="__main__", argv=[sys.argv[0], *rest], verbosity=2, warnings="ignore")
