#!/usr/bin/env python3
"""Depth through the daemon: the bytes of the plain replay, and readers that come late, hang, die or are too many.

usage: depth_test.py --daemon EGOFOCUSD --app EGOFOCUS --recording DIR --source ROOT --cc CC [test ...]
"""
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

import daemon_process
from daemon_process import DaemonTest, wait_for
from depth_layout import DepthReader


def build_example(folder):
    """The C example by its own Makefile, with an egofocus.pc as the installed one has it."""
    given = daemon_process.arguments
    work = pathlib.Path(folder)
    (work / "egofocus.pc").write_text(f"Name: egofocus\nDescription: x\nVersion: 0\nCflags: -I{given.source}/include\n")
    for name in ("watch_depth.c", "Makefile"):
        shutil.copy(f"{given.source}/examples/watch_depth/{name}", work)
    subprocess.run(["make", "-s", "-C", folder, f"CC={given.cc}", "CFLAGS=-O1 -Wall -Wextra -Werror"], check=True,
                   env=dict(os.environ, PKG_CONFIG_PATH=folder))
    return str(work / "watch_depth")


class Depth(DaemonTest):
    def test_virtual_clock_gives_the_bytes_of_the_plain_replay(self):
        daemon = self.daemon(source__recording=daemon_process.arguments.recording, source__clock="virtual", source__at_end=None, source__wait_for_reader=True, engine__rate_hz=None,
                             depth__slots=64)
        golden = daemon.folder / "golden.txt"
        subprocess.run([daemon_process.arguments.app, "replay", daemon_process.arguments.recording, "--backend", "focus",
                        "--golden", str(golden), "--json"], check=True, capture_output=True)
        expected = [line.split() for line in golden.read_text().splitlines() if line.startswith("tick ")]
        daemon.start()
        wait_for(lambda: os.path.exists(daemon.depth), "the socket")
        frames = list(DepthReader(daemon.depth).all_frames())
        self.assertEqual(daemon.process.wait(timeout=20), 0, daemon.said())
        self.assertGreater(len(expected), 5)
        self.assertEqual(len(frames), len(expected))
        for frame, line in zip(frames, expected):
            self.assertEqual(f"{frame.sequence} {frame.t_us} {frame.hash()}", f"{line[1]} {line[3]} {line[11]}")

    def test_c_example_and_a_second_reader_see_the_same_frames(self):
        daemon = self.daemon().started()
        with tempfile.TemporaryDirectory() as folder:
            example = build_example(folder)
            reader = DepthReader(daemon.depth)
            printed = subprocess.run([example, daemon.depth, "12"], capture_output=True, text=True, timeout=60, check=True)
            lines = printed.stdout.splitlines()
            self.assertEqual(len(lines), 12)
            same = 0
            for line in lines[-2:]:  # older ones may be overwritten by now
                words = line.split()
                frame = reader.frame(int(words[1]))
                if frame is not None:
                    self.assertEqual((str(frame.t_us), str(frame.events), str(frame.flags)), (words[3], words[5], words[7]))
                    same += 1
            self.assertGreater(same, 0)
            self.assertTrue(any(float(line.split()[-1]) > 0 for line in lines), printed.stdout)
            refused = subprocess.run([example, daemon.depth + ".not"], capture_output=True, text=True, timeout=60, check=False)
            self.assertEqual(refused.returncode, 3)
            self.assertIn("No such file", refused.stderr)
            # The daemon's end ends it.
            watching = subprocess.Popen([example, daemon.depth], stdout=subprocess.PIPE)
            watching.stdout.readline()
            daemon.stop()
            self.assertEqual(watching.wait(timeout=5), 0)
            watching.stdout.close()

    def test_readers_that_hang_or_die_harm_nobody(self):
        daemon = self.daemon(engine__rate_hz=20.0).started()
        with tempfile.TemporaryDirectory() as folder:
            example = build_example(folder)
            crowd = [subprocess.Popen([example, daemon.depth], stdout=subprocess.DEVNULL) for _ in range(6)]
            wait_for(lambda: daemon.health().get("readers") == 6, "six readers")
            for reader in crowd[:3]:
                reader.send_signal(signal.SIGSTOP)
            hanging = DepthReader(daemon.depth)  # never takes a wake-up
            for reader in crowd[3:]:
                reader.kill()
                reader.wait()
            before = daemon.health()["ticks_run"]
            watching = DepthReader(daemon.depth)
            seen = 0
            begin = time.monotonic()
            while seen < 40:
                self.assertTrue(watching.wait())
                seen += 1 if watching.frame(watching.newest()) else 0
            took = time.monotonic() - begin
            health = daemon.health()
            for reader in crowd[:3]:
                reader.kill()
                reader.wait()
            self.assertEqual(health["readers"], 5, "three that hang, one that sleeps, one that reads")
            self.assertGreater(health["ticks_run"] - before, 30)
            self.assertLess(took, 20)
            hanging.close()
            watching.close()
            wait_for(lambda: daemon.health()["readers"] == 0, "the dead to be forgotten")

    def test_too_many_readers_are_turned_away_and_the_others_stay(self):
        daemon = self.daemon().started()
        readers = [DepthReader(daemon.depth) for _ in range(32)]
        with self.assertRaises(ConnectionError):
            DepthReader(daemon.depth)
        self.assertTrue(readers[0].wait())
        readers.pop().close()
        wait_for(lambda: daemon.health()["readers"] == 31, "one to leave")
        readers.append(DepthReader(daemon.depth))
        for reader in readers:
            reader.close()

    def test_overload_is_thinned_bounded_and_counted(self):
        """The recording's events at a tenth of their rate: nothing waits, nothing is lost uncounted."""
        daemon = self.daemon(engine__rate_hz=10.0, engine__max_event_rate_hz=10000, engine__max_late_us=50000).started()
        wait_for(lambda: daemon.health()["ticks_run"] >= 20, "twenty ticks")
        h = daemon.health()
        self.assertEqual(h["events_ring_dropped"], 0)
        self.assertGreater(h["events_over_rate"], h["events_kept"])
        self.assertLess(h["events_kept"], 10000 * (h["up_s"] + 2))
        lost = sum(value for key, value in h.items() if key.startswith("events_") and key != "events_in")
        waiting = h["events_in"] - lost
        self.assertGreaterEqual(waiting, 0)
        self.assertLess(waiting, 10000)
        reader = DepthReader(daemon.depth)
        reader.wait()
        self.assertTrue(reader.frame(reader.newest()).flags & 16, "flagged as overload")
        reader.close()


if __name__ == "__main__":
    daemon_process.main()
