"""The depth memory read by its description in include/egofocus/depth_reader.h: nothing is shared with that header's code."""
import array
import mmap
import os
import socket
import struct

INFO = struct.Struct("<qqqqQQ dd3d3dd4d IIiII20x")


class Frame:
    def __init__(self, info, depth, confidence):
        (self.t_us, self.age_us, self.latency_us, self.window_begin_us, self.sequence, self.votes, self.scale, self.parallax,
         *rest) = info
        self.velocity, self.rate, self.sigma = rest[0:3], rest[3:6], rest[6]
        self.flags, self.events, self.hypotheses, self.width, self.height = rest[11:]
        self.depth, self.confidence = depth, confidence

    def hash(self):
        """The frame hash that `egofocus replay --golden` prints."""
        doubles = struct.pack("<8d", self.scale, self.parallax, *self.velocity, *self.rate)
        tail = struct.pack("<IIQqq", self.flags, self.events, self.votes, self.t_us, self.age_us)
        value = 14695981039346656037
        for byte in self.depth + self.confidence + doubles + tail:
            value = (value ^ byte) * 1099511628211 & 0xffffffffffffffff
        return f"{value:016x}"


class DepthReader:
    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.socket.settimeout(20)
        self.socket.connect(path)
        _, ancillary, _, _ = self.socket.recvmsg(64, socket.CMSG_SPACE(4))
        if not ancillary:
            raise ConnectionError("no descriptor: refused")
        self.descriptor = array.array("i", ancillary[0][2])[0]
        size = os.fstat(self.descriptor).st_size
        self.memory = mmap.mmap(self.descriptor, size, mmap.MAP_SHARED, mmap.PROT_READ)
        (magic, layout, self.header, self.slots, self.slot_bytes, self.width, self.height, self.depth_at,
         self.confidence_at) = struct.unpack_from("<8s8I", self.memory)
        assert (magic, layout) == (b"EGODEPTH", 1), (magic, layout)
        self.last = 0

    def word(self, at):
        return struct.unpack_from("<I", self.memory, at)[0]

    def newest(self):
        return self.word(64)

    def wait(self):
        """Until a frame is there that has not been read; False: the daemon has ended."""
        while self.newest() == self.last:
            if not self.socket.recv(64):
                return self.newest() != self.last
        return True

    def frame(self, number):
        """None when it has been overwritten."""
        slot = self.header + number % self.slots * self.slot_bytes
        pixels = self.width * self.height
        if self.word(slot) != 2 * number:
            return None
        info = INFO.unpack_from(self.memory, slot + 64)
        depth = self.memory[slot + self.depth_at:slot + self.depth_at + 2 * pixels]
        confidence = self.memory[slot + self.confidence_at:slot + self.confidence_at + pixels]
        if self.word(slot) != 2 * number:
            return None
        self.last = number
        return Frame(info, depth, confidence)

    def all_frames(self):
        """Each frame until the daemon ends; fails when one was overwritten."""
        while self.wait():
            for number in range(self.last + 1, self.newest() + 1):
                frame = self.frame(number)
                assert frame is not None, f"frame {number} was overwritten before it was read"
                yield frame

    def close(self):
        self.memory.close()
        os.close(self.descriptor)
        self.socket.close()
