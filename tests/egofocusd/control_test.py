#!/usr/bin/env python3
"""Health, metrics, recordings and the log of a running daemon, and those who ask badly.

usage: control_test.py --daemon EGOFOCUSD --app EGOFOCUS --recording DIR --source ROOT --cc CC [test ...]
"""
import json
import os
import pathlib
import re
import resource
import socket
import subprocess
import time

import daemon_process
from daemon_process import DaemonTest, wait_for


def connect(path):
    client = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    client.connect(path)
    client.settimeout(10)
    return client


class Control(DaemonTest):
    def test_health_is_json_and_the_client_prints_it(self):
        daemon = self.daemon().started()
        printed = daemon.run("--ask", "health")
        self.assertEqual(printed.returncode, 0)
        health = json.loads(printed.stdout)
        self.assertIn(health["state"], ("running", "degraded", "stalled", "waiting"))
        self.assertGreater(health["events_in"], 0)
        self.assertEqual(health["sources_lost"], 0)
        unknown = daemon.run("--ask", "dance")
        self.assertEqual(unknown.returncode, 2)
        self.assertIn("There are: health, record start", unknown.stdout)

    def test_those_who_ask_badly_wait_for_nobody_and_stop_nobody(self):
        daemon = self.daemon(engine__rate_hz=20.0).started()
        silent = [connect(daemon.control) for _ in range(20)]  # more than are taken at a time
        silent[0].sendall(b"hea")
        silent[1].sendall(b"x" * 100000)
        silent[2].close()
        before = daemon.ask("health")["ticks_run"]  # waits its turn: the silent ones are thrown out after 2 s
        self.assertGreater(before, 0)
        for client in silent[3:]:
            client.close()
        deaf = []
        for _ in range(50):  # ask, and never take the answer
            deaf.append(connect(daemon.control))
            deaf[-1].sendall(b"health\n")
        wait_for(lambda: daemon.health()["ticks_run"] > before + 20, "ticks go on")
        for request in (b"\n", b"\0\0\n", b"health health\n", b"record\n", b"\xff\xfe\n"):
            client = connect(daemon.control)
            client.sendall(request)
            self.assertIn("error", json.loads(client.recv(4096)))
            client.close()
        self.assertEqual(daemon.stop()[0], 0)

    def test_metrics_are_whole_whenever_they_are_read(self):
        daemon = self.daemon(metrics__file="egofocus.prom").start()
        file = daemon.folder / "egofocus.prom"
        wait_for(file.exists, "the metrics file")
        line = re.compile(r'^egofocus_[a-z_]+(\{[a-z]+="[^"\\]*"\})? \d+$')
        seen = set()
        until = time.monotonic() + 4
        while time.monotonic() < until:
            text = file.read_text()
            self.assertTrue(text.endswith("\n"))
            lines = text.splitlines()
            self.assertEqual([x for x in lines if not x.startswith("# TYPE egofocus_") and not line.match(x)], [])
            seen.add(next(x for x in lines if x.startswith("egofocus_ticks_run_total")))
            time.sleep(0.002)
        self.assertGreaterEqual(len(seen), 3, "written once a second")
        self.assertLessEqual(len(seen), 6)

    def test_a_recording_is_a_recording(self):
        daemon = self.daemon(record__folder=".", metrics__file="").started()
        self.assertIn("done", daemon.ask("record start"))
        self.assertIn("error", daemon.ask("record start"))
        time.sleep(2.5)
        self.assertIn("done", daemon.ask("record stop"))
        wait_for(lambda: daemon.health()["recording"] == 0, "the end of the recording")
        health = daemon.health()
        self.assertEqual((health["recorder_events_dropped"], health["recorder_frames_dropped"]), (0, 0))
        self.assertEqual(health["recording_failure"], "")
        folder = pathlib.Path(health["recording_folder"])
        self.assertEqual(sorted(p.name for p in folder.iterdir()),
                         ["camera.toml", "can.log", "egofocusd.toml", "events.raw", "health.jsonl", "vehicle.dbc"])
        self.assertGreaterEqual(len([json.loads(line) for line in (folder / "health.jsonl").read_text().splitlines()]), 2)
        replayed = subprocess.run([daemon_process.arguments.app, "replay", str(folder), "--backend", "focus", "--json"],
                                  capture_output=True, text=True, check=False)
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        report = json.loads(replayed.stdout)
        self.assertGreater(report["ticks_with_depth"], 3)
        self.assertGreater(report["health"]["odometry"]["used"], 20)
        self.assertEqual(report["health"]["events"]["out_of_order"], 0)
        self.assertGreater(report["health"]["events"]["kept"], 10000)
        # SIGTERM closes one that is on.
        self.assertIn("done", daemon.ask("record start"))
        wait_for(lambda: daemon.health()["recording_bytes"] > 100000, "some bytes")
        folder = pathlib.Path(daemon.health()["recording_folder"])
        self.assertEqual(daemon.stop()[0], 0)
        self.assertTrue((folder / "events.raw").exists())

    def test_a_full_disk_ends_the_recording_and_nothing_else(self):
        for limit in ("file size", "disk"):
            daemon = self.daemon(record__folder="disk")
            disk = daemon.folder / "disk"
            disk.mkdir()
            settings = {}
            if limit == "disk":
                mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(disk)], check=False,
                                         capture_output=True)
                if mounted.returncode != 0:
                    continue  # not permitted here; the limit below shows the same
                self.addCleanup(subprocess.run, ["umount", str(disk)], check=False)
            else:
                settings["preexec_fn"] = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200000, 200000))
            daemon.started(**settings)
            self.assertIn("done", daemon.ask("record start"))
            wait_for(lambda d=daemon: d.health()["recording"] == 0, "the recording to end")
            health = daemon.health()
            self.assertRegex(health["recording_failure"], "cannot be written \\((No space left|File too large)")
            self.assertIn("The recording ends here", daemon.said())
            self.assertTrue(health["recording_folder"] and not os.path.exists(health["recording_folder"]))
            self.assertTrue(os.path.exists(health["recording_folder"] + ".partial"))
            wait_for(lambda d=daemon, b=health["ticks_run"]: d.health()["ticks_run"] > b + 5, "depth goes on")
            self.assertEqual(daemon.stop()[0], 0)

    def test_the_log_is_short_however_often_something_is_asked(self):
        daemon = self.daemon().started()
        daemon.write_config(engine__threads=99)
        for _ in range(200):
            daemon.ask("reload")
        self.assertGreater(daemon.health()["log_lines_left_out"], 100)
        self.assertLess(len(daemon.said().splitlines()), 60)
        time.sleep(1.2)
        daemon.ask("reload")
        self.assertRegex(daemon.said(), r"lines before this one were left out")
        with_journal = self.daemon(env={"JOURNAL_STREAM": "8:1"}).started()
        self.assertRegex(with_journal.said(), "^<5>runs with ")

    def test_a_log_that_takes_nothing_stops_nothing(self):
        daemon = self.daemon()
        read_end, write_end = os.pipe()
        daemon.log = open(os.devnull, encoding="utf-8")  # closed with the daemon
        daemon.process = subprocess.Popen([daemon_process.arguments.daemon, "--config", str(daemon.config)], stderr=write_end)
        os.set_blocking(write_end, False)
        wait_for(lambda: daemon.health().get("ticks_run", 0) > 0, "the first tick")
        try:
            while True:
                os.write(write_end, b"x" * 4096)
        except BlockingIOError:
            pass
        daemon.write_config(engine__threads=99)
        for _ in range(5):
            self.assertIn("error", daemon.ask("reload"))
        before = daemon.health()["ticks_run"]
        wait_for(lambda: daemon.health()["ticks_run"] > before + 3, "ticks go on")
        self.assertEqual(daemon.stop()[0], 0)
        os.close(read_end)
        os.close(write_end)


if __name__ == "__main__":
    daemon_process.main()
