#!/usr/bin/env python3
"""How the daemon begins, changes and ends: signals, systemd's protocol, a second one, bad configurations.

usage: life_test.py --daemon EGOFOCUSD --app EGOFOCUS --recording DIR --source ROOT --cc CC [test ...]
"""
import os
import pathlib
import resource
import shutil
import signal
import socket
import stat
import subprocess
import time

import daemon_process
from daemon_process import Daemon, DaemonTest, wait_for
from depth_layout import DepthReader


class Life(DaemonTest):
    def test_term_ends_it_within_200_ms_and_leaves_nothing(self):
        took = []
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGTERM):
            daemon = self.daemon(engine__rate_hz=0.5 if number == signal.SIGINT else 20.0)
            daemon.start()
            wait_for(lambda: daemon.health(), "the daemon to answer")
            if number == signal.SIGTERM:
                wait_for(lambda: daemon.health().get("ticks_run", 0) > 3, "ticks")
            code, seconds = daemon.stop(number)
            self.assertEqual(code, 0, daemon.said())
            took.append(seconds)
            self.assertEqual(sorted(p.name for p in daemon.folder.iterdir()), ["egofocusd.toml", "log"])
        print("SIGTERM to exit, s:", [f"{seconds:.3f}" for seconds in took])
        self.assertLess(max(took), 0.2)

    def test_kill_and_start_again_leaves_nothing_stale(self):
        daemon = self.daemon().started()
        reader = DepthReader(daemon.depth)
        reader.wait()
        code, _ = daemon.stop(signal.SIGKILL)
        self.assertEqual(code, -signal.SIGKILL)
        while reader.wait():  # ends: the connection is gone, what was published can still be read
            self.assertIsNotNone(reader.frame(reader.newest()))
        self.assertTrue(os.path.exists(daemon.depth))
        daemon.started()
        again = DepthReader(daemon.depth)
        self.assertTrue(again.wait())
        self.assertEqual(daemon.stop()[0], 0)
        self.assertEqual(sorted(p.name for p in daemon.folder.iterdir()), ["egofocusd.toml", "log"])

    def test_a_second_daemon_is_refused_and_the_first_goes_on(self):
        daemon = self.daemon().started()
        second = daemon.run()
        self.assertEqual(second.returncode, 8)
        self.assertRegex(second.stderr, "^egofocusd: .*control.sock: another egofocusd runs with this socket. .*\n$")
        other = Daemon(control__socket=str(daemon.folder / "other.sock"), depth__socket=daemon.depth)
        self.addCleanup(other.close)
        self.assertEqual(other.run().returncode, 8)
        before = daemon.health()["ticks_run"]
        wait_for(lambda: daemon.health()["ticks_run"] > before, "the first one's next tick")
        reader = DepthReader(daemon.depth)
        self.assertTrue(reader.wait())
        reader.close()

    def test_sockets_are_not_for_everybody(self):
        daemon = self.daemon(control__group=False).started()
        self.assertEqual(stat.S_IMODE(os.stat(daemon.depth).st_mode), 0o660)
        self.assertEqual(stat.S_IMODE(os.stat(daemon.control).st_mode), 0o600)
        with open(self.daemon().folder / "control.sock", "w", encoding="utf-8") as file:
            file.write("somebody's notes")
        plain = Daemon(control__socket=file.name)
        self.addCleanup(plain.close)
        refused = plain.run()
        self.assertEqual(refused.returncode, 3)
        self.assertIn("is no socket", refused.stderr)
        with open(file.name, encoding="utf-8") as file:
            self.assertEqual(file.read(), "somebody's notes")

    def test_systemd_is_told_when_it_is_ready_alive_and_stopping(self):
        for abstract in (False, True):
            daemon = self.daemon()
            name = "\0egofocusd-test-" + str(os.getpid()) if abstract else str(daemon.folder / "notify")
            systemd = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
            systemd.settimeout(10)
            systemd.bind(name)
            daemon.env.update(NOTIFY_SOCKET=name.replace("\0", "@"), WATCHDOG_USEC="1000000")
            daemon.start()
            self.assertRegex(systemd.recv(500).decode(), "^READY=1\nSTATUS=depth every 200 ms$")
            messages = []
            while messages.count("WATCHDOG=1") < 3 or not any(m.startswith("STATUS=") for m in messages):
                self.assertLess(len(messages), 40)
                messages.append(systemd.recv(500).decode())
            daemon.stop()
            systemd.settimeout(0.5)
            while messages[-1] != "STOPPING=1":
                messages.append(systemd.recv(500).decode())
            systemd.close()

    def test_a_reload_takes_the_new_configuration_or_keeps_the_old_one(self):
        daemon = self.daemon().started()
        reader = DepthReader(daemon.depth)
        daemon.write_config(engine__rate_hz=25.0)
        daemon.process.send_signal(signal.SIGHUP)
        wait_for(lambda: daemon.health().get("reloads") == 1, "the reload")
        self.assertTrue(reader.wait())  # same grid: the reader stays connected
        begin, ticks = time.monotonic(), daemon.health()["ticks_run"]
        wait_for(lambda: daemon.health()["ticks_run"] >= ticks + 20, "twenty ticks at the new rate")
        self.assertLess(time.monotonic() - begin, 3.5)
        for change in ({"engine__threads": 99}, {"engine__no_such_key": 1}, {"source__recording": "/not/there"},
                       {"depth__socket": str(daemon.folder / "moved.sock")}):
            old = dict(daemon.options)
            daemon.write_config(**change)
            failed = daemon.health()["reloads_failed"]
            self.assertIn("error", daemon.ask("reload"))
            self.assertEqual(daemon.health()["reloads_failed"], failed + 1)
            before = daemon.health()["ticks_run"]
            wait_for(lambda b=before: daemon.health()["ticks_run"] > b, "a tick with the old configuration")
            daemon.options = old
        self.assertIn("Goes on with the old configuration", daemon.said())
        daemon.write_config(depth__slots=8)
        self.assertIn("done", daemon.ask("reload"))
        while reader.wait():  # another memory: it is told to come again
            reader.last = reader.newest()
        self.assertEqual(DepthReader(daemon.depth).slots, 8)
        self.assertEqual(daemon.stop()[0], 0)

    def test_everything_wrong_is_found_before_the_start(self):
        daemon = self.daemon(engine__thraeds=2, depth__slots=3, metrics__file="/not/there/x.prom")
        found = daemon.run("--check-config")
        self.assertEqual(found.returncode, 5)
        self.assertRegex(found.stderr, r"egofocusd.toml:\d+: \[engine\] has no key `thraeds`")
        self.assertRegex(found.stderr, r"egofocusd.toml:\d+: \[depth\] `slots` must be a power of two")
        self.assertIn("[metrics] file: /not/there is no folder", found.stderr)
        self.assertEqual(len(found.stderr.splitlines()), 3)
        for change, code, says in (({"source__recording": "/not/there"}, 3, "/not/there"),
                                   ({"engine__threads": 99}, 5, "bad number of threads"),
                                   ({"engine__backend": "network", "engine__model": "/not/there.efm"}, 3, "not/there.efm"),
                                   ({"depth__socket": "/not/there/depth.sock"}, 3, "/not/there")):
            wrong = self.daemon(**change)
            self.assertEqual(wrong.run("--check-config").returncode, 5, change)
            self.assertIn(says, wrong.run("--check-config").stderr)
            begun = wrong.run()
            self.assertEqual(begun.returncode, code, begun.stderr)
            self.assertEqual(len(begun.stderr.splitlines()), 1, begun.stderr)
            self.assertFalse(os.path.exists(wrong.control))
        sound = self.daemon()
        self.assertEqual(sound.run("--check-config").returncode, 0)
        printed = sound.run("--print-config").stdout
        with open(f"{daemon_process.arguments.source}/apps/egofocusd/egofocusd.toml", encoding="utf-8") as shipped:
            self.assertEqual(printed, shipped.read())
        self.assertEqual(sound.run("--no-such-option").returncode, 2)
        self.assertEqual(Daemon.run(sound, "--ask", "health").returncode, 3)

    def test_devices_that_are_not_there_are_all_named(self):
        daemon = self.daemon()
        folder = daemon.folder
        recording = pathlib.Path(daemon_process.arguments.recording)
        shutil.copy(recording / "vehicle.dbc", folder)
        camera = (recording / "camera.toml").read_text(encoding="utf-8")
        (folder / "robot.toml").write_text(camera + '\n[v4l2]\ndevice = "/dev/no_such_video"\n', encoding="utf-8")
        live = ('[source]\nevents = "v4l2"\nmotion = "can"\n[can]\ninterface = "no_such_can"\n[engine]\ncamera = "robot.toml"\n'
                f'backend = "focus"\n[depth]\nsocket = "{daemon.depth}"\n[control]\nsocket = "{daemon.control}"\n')
        daemon.config.write_text(live, encoding="utf-8")
        checked = daemon.run("--check-config")
        self.assertEqual(checked.returncode, 5)
        for words in ("[v4l2] of ", "[can] interface no_such_can"):
            self.assertIn(words, checked.stderr)
        started = daemon.run()
        self.assertIn(started.returncode, (10, 11))  # a kernel without CAN, or without V4L2, is another cause
        self.assertIn("[can] interface no_such_can", started.stderr)

    def test_no_memory_at_start_is_one_line(self):
        daemon = self.daemon(engine__threads=8)
        limit = 64 << 20
        refused = daemon.run(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
        self.assertEqual(refused.returncode, 9, refused.stderr)
        self.assertRegex(refused.stderr, "^egofocusd: .*(no memory|system refused).*\n$")

    def test_the_end_of_the_recording_ends_it(self):
        daemon = self.daemon(source__at_end="stop").start()
        self.assertEqual(daemon.process.wait(timeout=30), 0, daemon.said())
        self.assertIn("the recording has ended", daemon.said())

    def test_the_unit_is_sound(self):
        analyze = shutil.which("systemd-analyze")
        if analyze is None:
            self.skipTest("no systemd-analyze here")
        unit = self.daemon().folder / "egofocusd.service"
        with open(f"{daemon_process.arguments.source}/apps/egofocusd/egofocusd.service", encoding="utf-8") as template:
            unit.write_text(template.read().replace("ExecStart=egofocusd", "ExecStart=" + daemon_process.arguments.daemon))
        verified = subprocess.run([analyze, "verify", "--man=no", str(unit)], capture_output=True, text=True, check=False)
        complaints = [line for line in verified.stderr.splitlines() if "egofocusd.service" in line]
        self.assertEqual(complaints, [])
        rated = subprocess.run([analyze, "security", "--offline=yes", "--threshold=20", str(unit)], capture_output=True,
                               text=True, check=False)
        self.assertEqual(rated.returncode, 0, rated.stdout + rated.stderr)
        print(rated.stdout.splitlines()[-1])


if __name__ == "__main__":
    daemon_process.main()
