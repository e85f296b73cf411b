"""Faults that need a real process: signals, disks, readers, other daemons, configurations, memory, a tick that hangs."""
import json
import os
import pathlib
import resource
import shutil
import signal
import socket
import subprocess
import tempfile
import time

import daemon_process
from daemon_process import Daemon, wait_for
from depth_layout import DepthReader
from hung_thread import HungThread

MOST_GROWTH_PERCENT = 1.0


def resident_kib(pid):
    for line in pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    return 0


class Fault:
    """A daemon in good health, one fault done to it, and the row of the table that comes of it."""

    def __init__(self, fault, made, **options):
        self.row = {"fault": fault, "made": made, "lost": {}, "good_after_s": 0.0, "rss_percent": None, "flags": 0,
                    "remark": "", "complaints": ""}
        options.setdefault("engine__rate_hz", 20.0)
        self.daemon = Daemon(**options)
        self.closing = [self.daemon.close]
        self.memory = 0

    def __enter__(self):
        return self

    def __exit__(self, kind, error, trace):
        if error is not None and not isinstance(error, KeyboardInterrupt):
            self.complain(f"{kind.__name__}: {error}")
        for close in reversed(self.closing):
            close()
        return kind is not KeyboardInterrupt

    def complain(self, what):
        self.row["complaints"] += ("; " if self.row["complaints"] else "") + str(what)

    def expect(self, is_true, what):
        if not is_true:
            self.complain(what)

    def remark(self, what):
        self.row["remark"] += ("; " if self.row["remark"] else "") + what

    def started(self, **settings):
        self.daemon.started(**settings)
        self.wait_for_ticks(40)  # buffers have been touched
        self.memory = resident_kib(self.daemon.process.pid)
        return self.daemon

    def wait_for_ticks(self, count, seconds=20):
        """So many more; the time that they took."""
        begin = time.monotonic()
        first = None
        while True:
            health = self.daemon.health()
            if health:
                first = health["ticks_run"] if first is None else first
                if health["ticks_run"] >= first + count:
                    return time.monotonic() - begin
            if time.monotonic() - begin > seconds:
                raise AssertionError(f"no {count} ticks in {seconds} s")
            time.sleep(0.01)

    def good_after(self, begin):
        """Until a frame with depth is in the memory that is newer than `begin`."""
        while True:
            try:
                reader = DepthReader(self.daemon.depth)
                break
            except OSError:
                if time.monotonic() - begin > 20:
                    raise
                time.sleep(0.005)
        reader.last = reader.newest()
        reader.wait()
        while True:
            frame = reader.frame(reader.newest())
            if frame is not None:
                self.row["flags"] |= frame.flags
                if frame.events > 0:
                    break
            reader.wait()
        reader.close()
        self.row["good_after_s"] = round(time.monotonic() - begin, 3)

    def memory_is_constant(self):
        after = resident_kib(self.daemon.process.pid)
        percent = 100.0 * (after - self.memory) / self.memory
        self.row["rss_percent"] = round(percent, 2)
        self.expect(percent < MOST_GROWTH_PERCENT, f"memory grew by {percent:.2f} %")

    def stops(self):
        code, seconds = self.daemon.stop()
        self.expect(code == 0, f"ended with {code}")
        return seconds


def killed():
    with Fault("SIGKILL and restart", "kill -9 while readers are connected, started again at once") as f:
        daemon = f.started()
        reader = DepthReader(daemon.depth)
        ticks = daemon.health()["ticks_run"]
        daemon.stop(signal.SIGKILL)
        begin = time.monotonic()
        daemon.start()
        f.good_after(begin)
        f.row["lost"] = {"ticks while it was away": round(f.row["good_after_s"] * 20)}
        f.expect(ticks > 0 and not reader_is_connected(reader), "a reader of the dead one was not told")
        f.stops()
    return f.row


def reader_is_connected(reader):
    reader.socket.settimeout(2)
    try:
        while reader.socket.recv(64):
            pass
        return False
    except TimeoutError:
        return True


def terminated():
    with Fault("SIGTERM", "five times, each with a reader and a recording that is on", record__folder=".") as f:
        took = []
        for _ in range(5):
            daemon = f.daemon.started()
            reader = DepthReader(daemon.depth)
            daemon.ask("record start")
            f.wait_for_ticks(3)
            took.append(f.stops())
            f.expect(not os.path.exists(daemon.depth) and not os.path.exists(daemon.control), "a socket is left")
            reader.close()
        partial = [p.name for p in f.daemon.folder.iterdir() if p.name.endswith(".partial")]
        f.expect(not partial, f"recordings are not whole: {partial}")
        f.expect(max(took) <= 0.2, f"took {max(took):.3f} s")
        f.remark(f"ends within {1000 * max(took):.0f} ms")
    return f.row


def second_daemon():
    with Fault("second daemon on the same sockets", "egofocusd with the same configuration, five times") as f:
        daemon = f.started()
        for _ in range(5):
            second = daemon.run()
            f.expect(second.returncode == 8, f"exit code {second.returncode}")
        f.good_after(time.monotonic())
        f.memory_is_constant()
        f.remark("exit code 8: " + second.stderr.strip().split(": ", 2)[-1])
        f.stops()
    return f.row


def hanging_readers():
    with Fault("readers that hang", "5 stopped by SIGSTOP, 5 that never take a wake-up, 5 killed") as f:
        daemon = f.started()
        script = ("import sys; sys.path[:0] = sys.argv[2:]; from depth_layout import DepthReader\n"
                  "r = DepthReader(sys.argv[1]); print('on', flush=True)\nwhile r.wait(): r.last = r.newest()\n")
        crowd = []
        for _ in range(10):
            reader = subprocess.Popen(["/usr/bin/python3", "-c", script, daemon.depth, *daemon_process_folders()],
                                      stdout=subprocess.PIPE)
            f.closing.append(lambda reader=reader: (reader.kill(), reader.wait(), reader.stdout.close()))
            reader.stdout.readline()
            crowd.append(reader)
        deaf = [DepthReader(daemon.depth) for _ in range(5)]
        for reader in crowd[:5]:
            reader.send_signal(signal.SIGSTOP)
        for reader in crowd[5:]:
            reader.kill()
        before = daemon.health()
        took = f.wait_for_ticks(100)
        f.good_after(time.monotonic())
        after = daemon.health()
        f.expect(after["readers"] == 10, f"{after['readers']} readers")
        if after["ticks_skipped"] > before["ticks_skipped"]:  # the machine's doing: other work goes on there
            f.row["lost"] = {"ticks_skipped": after["ticks_skipped"] - before["ticks_skipped"]}
        f.remark(f"100 ticks at 20 Hz in {took:.1f} s")
        f.memory_is_constant()
        for reader in deaf:
            reader.close()
        f.stops()
    return f.row


def daemon_process_folders():
    return [str(pathlib.Path(daemon_process.__file__).parent)]


def full_disk():
    with Fault("disk full while recording", "a limit of 200 kB on files, twice", record__folder=".") as f:
        daemon = f.started(preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (200000, 200000)))
        for _ in range(2):
            f.memory = resident_kib(daemon.process.pid)  # of the second time: the first touches the buffers
            daemon.ask("record start")
            wait_for(lambda: daemon.health()["recording"] == 0, "the recording to end")
        health = daemon.health()
        f.expect("File too large" in health["recording_failure"], "the failure is not told")
        f.expect(os.path.exists(health["recording_folder"] + ".partial"), "what there was is gone")
        f.row["lost"] = {"the rest of the recording": 1}
        f.good_after(time.monotonic())
        f.wait_for_ticks(20)
        f.memory_is_constant()
        f.stops()
    return f.row


def slow_disk():
    with Fault("disk that hangs while recording", "its thread alone is stopped by ptrace until events are dropped",
               record__folder=".", record__buffer_events=65536) as f:
        daemon = f.started()
        daemon.ask("record start")
        wait_for(lambda: daemon.health()["recording_bytes"] > 0, "some bytes")
        tid = thread_named(daemon.process.pid, "egofocusd")
        with HungThread(tid):
            wait_for(lambda: daemon.health()["recorder_events_dropped"] > 0, "events to be dropped", 60)
            f.wait_for_ticks(20)
        health = daemon.health()
        f.row["lost"] = {"recorder_events_dropped": health["recorder_events_dropped"]}
        f.good_after(time.monotonic())
        f.remark("depth went on all the while")
        f.stops()
    return f.row


def thread_named(pid, name):
    """Of the threads but the first."""
    for task in pathlib.Path(f"/proc/{pid}/task").iterdir():
        if int(task.name) != pid and (task / "comm").read_text(encoding="ascii").strip() == name:
            return int(task.name)
    raise AssertionError(f"no thread {name}")


def reloaded():
    with Fault("config and model reload", "SIGHUP: another rate, another model, back, ten times") as f:
        daemon = f.started()
        model = f"{daemon_process.arguments.source}/fixtures/network/model.efm"
        longest = 0.0
        for i in range(10):
            network = {"engine__backend": "network", "engine__model": model}
            focus = {"engine__backend": "focus", "engine__model": None}
            daemon.write_config(engine__rate_hz=20.0 + i % 3, **(network if i % 2 == 0 else focus))
            begin = time.monotonic()
            answer = daemon.ask("reload")
            f.expect("done" in answer, answer)
            f.wait_for_ticks(1)
            longest = max(longest, time.monotonic() - begin)
            if i == 3:
                f.wait_for_ticks(20)
                f.memory = resident_kib(daemon.process.pid)
        f.row["good_after_s"] = round(longest, 3)
        f.row["lost"] = {"ticks while one gives way to the other": round(longest * 20)}
        f.wait_for_ticks(20)
        f.memory_is_constant()
        f.stops()
    return f.row


def badly_reloaded():
    with Fault("reload of what is wrong", "unknown key, no such model, devices that are not there, twice") as f:
        daemon = f.started()
        good = dict(daemon.options)
        live = camera_on_usb(daemon)
        longest = 0.0
        for i, change in enumerate(({"engine__thraeds": 1}, {"engine__backend": "network", "engine__model": "/not/there"},
                                    {"source__events": "usb", "source__motion": "can", "source__recording": None,
                                     "source__at_end": None, "engine__camera": live}) * 2):
            daemon.options = dict(good)
            daemon.write_config(**change)
            begin = time.monotonic()
            answer = daemon.ask("reload")
            f.expect("error" in answer, answer)
            f.wait_for_ticks(1)
            longest = max(longest, time.monotonic() - begin)
            f.expect(daemon.health()["reloads_failed"] == i + 1, "not counted")
            if i == 2:  # each kind once: both engines have been in memory
                f.wait_for_ticks(20)
                f.memory = resident_kib(daemon.process.pid)
        f.row["good_after_s"] = round(longest, 3)
        f.row["lost"] = {"reloads_failed": daemon.health()["reloads_failed"]}
        f.remark("the old configuration goes on")
        f.wait_for_ticks(20)
        f.memory_is_constant()
        f.stops()
    return f.row


def camera_on_usb(daemon):
    """A camera.toml for devices that are not there: found out when the old sources have ended already."""
    folder = daemon.folder / "live"
    folder.mkdir()
    given = pathlib.Path(Daemon.light)
    shutil.copy(given / "vehicle.dbc", folder)
    (folder / "camera.toml").write_text((given / "camera.toml").read_text(encoding="utf-8") + "\n[usb]\nserial = \"none such\"\n",
                                        encoding="utf-8")
    return str(folder / "camera.toml")


def no_memory():
    with Fault("out of memory at start", "limits of 16, 32 and 64 MiB on the address space", engine__threads=8) as f:
        codes = []
        for mib in (16, 32, 64):
            limit = mib << 20
            begun = f.daemon.run(preexec_fn=lambda limit=limit: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
            codes.append(begun.returncode)
            f.expect(len(begun.stderr.splitlines()) == 1, begun.stderr)
        f.expect(9 in codes and all(code in (9, 127) for code in codes), f"exit codes {codes}")
        f.remark(f"exit codes {codes}, one line: {begun.stderr.strip()}")
        f.row["good_after_s"] = None
    return f.row


def ended(process, hung):
    """Exit code of a process whose thread is traced."""
    wait_for(lambda: (hung.take_leave(), process.poll())[1] is not None, "the end of the process")
    return process.returncode


def hung_tick():
    """The watchdog's protocol, as systemd has it: silence for WatchdogSec= is answered by SIGABRT and a new start."""
    watchdog_s = 2.0
    with Fault("tick hangs", f"its thread alone is stopped by ptrace; WatchdogSec={watchdog_s:.0f}") as f:
        folder = tempfile.mkdtemp()
        f.closing.append(lambda: shutil.rmtree(folder))
        systemd = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        f.closing.append(systemd.close)
        systemd.bind(folder + "/notify")
        f.daemon.env.update(NOTIFY_SOCKET=folder + "/notify", WATCHDOG_USEC=str(int(watchdog_s * 1e6)))
        daemon = f.started()
        systemd.settimeout(10)
        while b"WATCHDOG=1" not in systemd.recv(500):
            pass
        hung = time.monotonic()
        with HungThread(thread_named(daemon.process.pid, "egofocus-tick")) as tick:
            last_beat = hung
            systemd.settimeout(watchdog_s)
            try:
                while time.monotonic() - hung < 20:
                    if b"WATCHDOG=1" in systemd.recv(500):
                        last_beat = time.monotonic()
            except TimeoutError:
                pass
            noticed = time.monotonic() - hung
            f.expect(daemon.health().get("ticks_run", 0) > 0, "health is not told while the tick hangs")
            daemon.process.send_signal(signal.SIGABRT)  # what systemd does
            code = ended(daemon.process, tick)
        f.expect(code == -signal.SIGABRT, f"ended with {code}")
        f.expect(noticed < 10, f"noticed after {noticed:.1f} s")
        begin = time.monotonic()
        daemon.start()
        f.good_after(begin)
        f.row["good_after_s"] = round(f.row["good_after_s"] + noticed, 3)
        f.row["lost"] = {"ticks until the new start has depth": round(f.row["good_after_s"] * 20)}
        f.remark(f"last WATCHDOG=1 {last_beat - hung:.1f} s after the hang, restart after {noticed:.1f} s")
        f.stops()
    return f.row


def hung_tick_at_stop():
    with Fault("SIGTERM while the tick hangs", "its thread alone is stopped by ptrace") as f:
        daemon = f.started()
        with HungThread(thread_named(daemon.process.pid, "egofocus-tick")) as tick:
            begin = time.monotonic()
            daemon.process.send_signal(signal.SIGTERM)
            code = ended(daemon.process, tick)
            took = time.monotonic() - begin
        f.expect(code == 0 and took <= 0.2, f"ended with {code} after {took:.3f} s")
        f.expect(not os.path.exists(daemon.depth), "a socket is left")
        f.remark(f"ends within {1000 * took:.0f} ms")
        f.row["good_after_s"] = None
    return f.row


ALL = (killed, terminated, second_daemon, hanging_readers, full_disk, slow_disk, reloaded, badly_reloaded, no_memory,
       hung_tick, hung_tick_at_stop)


def rows(names=()):
    for fault in ALL:
        if not names or fault.__name__ in names:
            yield json.loads(json.dumps(fault()))
